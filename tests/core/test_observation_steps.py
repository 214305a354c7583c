"""One observation taken apart: each step is what the observation itself is made of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.errors import GeometryError
from bspline_slam.fitting import FittingConfig
from bspline_slam.observation import ChordLengthNoise
from bspline_slam.observation_steps import (
    LARGEST_CONDITION,
    covariance_terms,
    observation_steps,
    observe_spline,
    observed_relation,
)
from bspline_slam.relation import Relation, RelationConfig


def arc(rng: np.random.Generator, beams: int, noise: float = 0.01) -> np.ndarray:
    """Beam ends on a wall that bends around the sensor."""
    bearing = np.linspace(-0.7, 0.6, beams)
    reach = 3.0 + 0.4 * np.sin(3.0 * bearing) + noise * rng.standard_normal(beams)
    return reach[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], -1)


@pytest.mark.parametrize("beams", [4, 7, 30, 180])
def test_every_step_leads_to_the_next(beams: int) -> None:
    points = arc(np.random.default_rng(beams), beams)
    steps = observation_steps(points)
    assert steps.parameters[0] == 0.0
    assert steps.parameters[-1] == 1.0
    assert np.all(np.diff(steps.parameters) > 0)
    assert np.allclose(steps.lengths, steps.parameters * steps.lengths[-1])
    assert np.allclose(steps.basis.sum(axis=1), 1.0)
    assert np.all((steps.basis > 0).sum(axis=1) <= steps.curve.degree + 1)
    assert np.allclose(steps.basis @ steps.curve.control_points, steps.curve(steps.parameters))
    best = np.linalg.lstsq(steps.basis, points, rcond=None)[0]
    assert np.allclose(steps.curve.control_points, best, atol=1e-3)
    assert steps.rms < 0.05


def test_the_terms_add_up_to_the_covariance_of_the_observation() -> None:
    points = arc(np.random.default_rng(1), 60)
    frame = BSpline(3, clamped_knots(9), np.zeros((9, 2)))
    noise = replace(ChordLengthNoise(), unseen=0.0)
    terms = covariance_terms(points, frame, FittingConfig(), noise)
    whole = observe_spline(points, frame, FittingConfig(), noise)
    assert np.allclose(terms.total, whole.blocks, rtol=1e-6, atol=1e-12)
    assert np.linalg.eigvalsh(terms.noise).min() > 0
    assert np.allclose(terms.resolution, noise.resolution * np.eye(2), rtol=1e-3, atol=1e-9)
    spread = terms.chord_error[:, 0, 0]
    assert spread[[0, -1]] == pytest.approx(0.0, abs=1e-9)
    assert spread.argmax() == 4
    assert spread[4] == pytest.approx(0.5 * noise.cons, rel=1e-3)


def test_more_noise_of_the_laser_only_widens_its_own_term() -> None:
    points = arc(np.random.default_rng(2), 50)
    quiet, loud = (observation_steps(points, FittingConfig(range_noise=sigma)).terms for sigma in (0.01, 0.02))
    assert np.all(np.trace(loud.noise - quiet.noise, axis1=1, axis2=2) > 0)
    assert np.allclose(loud.chord_error, quiet.chord_error, atol=1e-8)


def test_turning_the_robot_turns_every_step() -> None:
    points = arc(np.random.default_rng(3), 50)
    pose = np.array([0.0, 0.0, 1.1])
    here, there = observation_steps(points), observation_steps(se2.transform(pose, points))
    turn = se2.rotation(pose[2])
    assert np.allclose(there.parameters, here.parameters)
    assert np.allclose(there.curve.control_points, se2.transform(pose, here.curve.control_points), atol=1e-6)
    assert np.allclose(there.terms.total, turn @ here.terms.total @ turn.T, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_points_however_uneven_determine_the_control_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    along = np.sort(rng.uniform(0.0, 1.0, 20) ** 4) * 6.0
    points = np.stack([1.0 + along, 0.5 + 0.2 * np.sin(along)], -1)
    steps = observation_steps(points)
    assert np.linalg.cond(steps.basis) <= LARGEST_CONDITION or len(steps.curve.control_points) == 4
    assert np.abs(steps.curve.control_points - points.mean(axis=0)).max() < 15.0


def test_one_point_is_no_observation() -> None:
    with pytest.raises(GeometryError, match="at least two distinct points"):
        observation_steps(np.ones((5, 2)))


@pytest.mark.parametrize(
    ("first", "last", "expected"), [(0, 60, Relation.FULL), (15, 45, Relation.PART), (0, 45, Relation.PART)]
)
def test_the_relation_does_not_depend_on_the_sense_of_the_full_spline(
    first: int, last: int, expected: Relation
) -> None:
    points = arc(np.random.default_rng(4), 60, noise=0.002)
    whole = observation_steps(points).curve
    for curve in (whole, whole.reversed()):
        seen = observed_relation(curve, points[first:last], RelationConfig())
        assert seen.decision.relation is expected
        assert np.allclose(seen.full_spline(np.array(seen.full_spline.domain)), points[[0, -1]], atol=0.05)


def test_as_many_control_points_as_wanted_where_the_points_determine_them() -> None:
    rng = np.random.default_rng(5)
    assert len(observation_steps(arc(rng, 60), control_points=13).curve.control_points) == 13
    assert 4 <= len(observation_steps(arc(rng, 8), control_points=13).curve.control_points) <= 8
