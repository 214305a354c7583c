"""Full, part or extension: the decision, the parameters of the ends, the grown spline."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.errors import GeometryError
from bspline_slam.fitting import FittingConfig, fit_parameters
from bspline_slam.relation import EndRelation, Relation, RelationConfig, extended, relate, trace

CONFIG = RelationConfig()
FITTING = FittingConfig()


def arc(first: float, last: float, step: float = 0.5) -> np.ndarray:
    """Points of a circle of 3 m around the sensor, from bearing to bearing (degrees)."""
    angle = np.radians(np.arange(first, last + 1e-9, step))
    return 3.0 * np.stack([np.cos(angle), np.sin(angle)], -1)


def spline(first: float, last: float) -> BSpline:
    points = arc(first, last, 0.25)
    return fit_parameters(points, np.linspace(0, 1, len(points)), clamped_knots(13), FITTING).curve


@pytest.mark.parametrize(
    ("seen", "relation", "start", "end"),
    [
        ((30, 100), Relation.FULL, EndRelation.COINCIDES, EndRelation.COINCIDES),
        ((45, 80), Relation.PART, EndRelation.INSIDE, EndRelation.INSIDE),
        ((10, 100), Relation.EXTENSION, EndRelation.BEYOND, EndRelation.COINCIDES),
        ((50, 130), Relation.EXTENSION, EndRelation.INSIDE, EndRelation.BEYOND),
    ],
)
@pytest.mark.parametrize("other_way_round", [False, True])
def test_bearings_decide(
    seen: tuple[float, float], relation: Relation, start: EndRelation, end: EndRelation, other_way_round: bool
) -> None:
    curve, points, share = spline(30, 100), arc(*seen), (np.array(seen) - 30) / 70
    if other_way_round:
        curve, points, share, start, end = curve.reversed(), points[::-1], 1 - share[::-1], end, start
    found = relate(curve, points, CONFIG)
    assert (found.relation, found.start.relation, found.end.relation) == (relation, start, end)
    assert np.allclose(found.span, share, atol=0.01)
    assert np.allclose(found.parameters(points), np.linspace(share[0], share[1], len(points)), atol=0.01)


def test_an_end_within_the_threshold_coincides() -> None:
    found = relate(spline(30, 100), arc(30.6, 99.4, 0.4), CONFIG)
    assert found.relation is Relation.FULL
    assert found.span == (0.0, 1.0)


def test_a_beam_that_misses_is_turned_until_it_hits() -> None:
    parameter, turns, hit = trace(spline(30, 100), arc(27.25, 27.25)[0], np.radians(27.25), CONFIG.resolution)
    assert turns == 6
    assert parameter == pytest.approx(0.25 / 70, abs=1e-3)
    assert np.allclose(hit, arc(30.25, 30.25)[0], atol=2e-3)


def test_bearings_may_pass_the_cut_behind_the_robot() -> None:
    found = relate(spline(140, 220), arc(160, 250), CONFIG)
    assert found.relation is Relation.EXTENSION
    assert np.allclose(found.span, (0.25, 1.375), atol=0.01)


def test_an_extension_covers_old_and_new_with_as_many_control_points() -> None:
    curve, points = spline(30, 100), arc(60, 140)
    decision = relate(curve, points, CONFIG)
    grown = extended(curve, points, decision, len(curve.control_points), FITTING)
    assert len(grown.control_points) == len(curve.control_points)
    assert grown.domain == pytest.approx((0.0, 110 / 70), abs=0.01)
    assert np.allclose(grown(np.array(grown.domain)), [arc(30, 30)[0], arc(140, 140)[0]], atol=0.01)
    old = np.linspace(0, 1, 20)
    assert np.allclose(grown(old), curve(old), atol=0.01)


def test_of_several_crossings_of_a_beam_the_one_at_its_range_counts() -> None:
    """The curve goes out at 3 m and comes back at 5 m behind itself."""
    angle = np.linspace(-0.5, 0.5, 40)
    near, far = (r * np.stack([np.cos(angle), np.sin(angle)], -1) for r in (3.0, 5.0))
    points = np.concatenate([near, far[::-1]])
    curve = fit_parameters(points, np.linspace(0, 1, 80), clamped_knots(25), FITTING).curve
    for reach in (3.0, 5.0):
        _, turns, hit = trace(curve, np.array([reach, 0.0]), 0.0, CONFIG.resolution)
        assert turns == 0
        assert hit == pytest.approx([reach, 0.0], abs=0.02)


def test_data_that_run_against_the_full_spline_are_refused() -> None:
    with pytest.raises(GeometryError, match="run against it"):
        relate(spline(30, 100).reversed(), arc(45, 80), CONFIG)
