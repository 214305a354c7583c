"""Measuring: distances and angles scatter as much as their standard deviations say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends.direct import Direct
from bspline_slam.backends.protocol import Estimate
from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.errors import SolverError
from bspline_slam.measuring import (
    Measurement,
    Picked,
    PickedControlPoint,
    PickedPlace,
    PickedPose,
    factorised,
    measure,
    thing_of,
)
from bspline_slam.spline_map import MapSpline, SplineMap
from core.backends.conftest import make_world

PAIRS: list[tuple[Picked, Picked]] = [
    (PickedPose(0), PickedPose(3)),
    (PickedPose(1), PickedPlace(0, 0.7)),
    (PickedPlace(0, 0.4), PickedPlace(1, 0.9)),
    (PickedControlPoint(0, 1), PickedPlace(1, 0.3)),
    (PickedControlPoint(0, 0), PickedControlPoint(1, 2)),
]


@pytest.fixture(scope="module")
def solved() -> tuple[Estimate, SplineMap]:
    """A small world, its estimate, and curves over its control points."""
    graph = make_world(np.random.default_rng(4)).graph
    graph = replace(graph, key_scans=np.arange(len(graph.poses)), spline_ids=np.arange(len(graph.spline_ids)))
    estimate = Direct().solve(graph)
    splines = []
    for number, first, end in zip(graph.spline_ids, graph.spline_first, graph.spline_first[1:], strict=False):
        points = estimate.control_points[first:end]
        curve = BSpline(3, uniform_knots(0.0, 1.2 / (len(points) - 3), len(points)), points)
        splines.append(MapSpline(int(number), curve, curve.domain, 0))
    return estimate, SplineMap(tuple(splines))


def place_and_direction(
    splines: SplineMap, poses: np.ndarray, points: np.ndarray, estimate: Estimate, picked: Picked
) -> tuple[np.ndarray, float | None]:
    """Where a thing lies in another state; a place on a curve is where that cuts the old normal."""
    graph = estimate.graph
    match picked:
        case PickedPose(scan=scan):
            return poses[scan, :2], float(poses[scan, 2])
        case PickedControlPoint(spline=spline, number=number):
            return points[graph.spline_first[list(graph.spline_ids).index(spline)] + number], None
        case PickedPlace(spline=spline, t=t):
            k = list(graph.spline_ids).index(spline)
            old = splines[spline].curve
            new = old.with_control_points(points[graph.spline_first[k] : graph.spline_first[k + 1]])
            origin, along = old(np.array([t]))[0], old(np.array([t]), 1)[0]
            at = t
            for _ in range(8):
                at -= float((new(np.array([at]))[0] - origin) @ along / (new(np.array([at]), 1)[0] @ along))
            speed = new(np.array([at]), 1)[0]
            return new(np.array([at]))[0], float(np.arctan2(speed[1], speed[0]))


@pytest.mark.parametrize("pair", PAIRS, ids=lambda pair: "-".join(type(one).__name__ for one in pair))
def test_sigmas_are_what_samples_scatter(solved: tuple[Estimate, SplineMap], pair: tuple[Picked, Picked]) -> None:
    estimate, splines = solved
    factor = factorised(estimate)
    covariance = factor.solve(np.eye(estimate.graph.unknowns))
    shrunk = 1e-2  # small moves: the comparison is of first order
    rng, split = np.random.default_rng(9), 3 * len(estimate.poses)
    root = np.linalg.cholesky(0.5 * (covariance + covariance.T) + 1e-15 * np.eye(len(covariance)))
    distances, angles = [], []
    for _ in range(3000):
        moved = shrunk * root @ rng.normal(size=len(root))
        poses, points = (
            estimate.poses + moved[:split].reshape(-1, 3),
            estimate.control_points + moved[split:].reshape(-1, 2),
        )
        (p, a), (q, b) = (place_and_direction(splines, poses, points, estimate, one) for one in pair)
        distances.append(np.linalg.norm(q - p))
        angles.append(np.nan if a is None or b is None else b - a)
    found = measure(estimate, splines, factor, *pair)
    assert found.distance == pytest.approx(np.mean(distances), abs=1e-3)
    assert found.distance_sigma == pytest.approx(np.std(distances) / shrunk, rel=0.06)
    if found.angle is None:
        assert np.isnan(angles).all()
    else:
        turned = se2.wrap(np.array(angles) - found.angle)
        spread = np.std(0.5 * se2.wrap(2.0 * turned)) / shrunk
        assert found.angle_sigma == pytest.approx(spread, rel=0.06)


def test_a_measurement_the_other_way_round_is_as_long_and_turns_back(solved: tuple[Estimate, SplineMap]) -> None:
    estimate, splines = solved
    factor = factorised(estimate)
    for first, second in PAIRS:
        there, back = (measure(estimate, splines, factor, *pair) for pair in ((first, second), (second, first)))
        assert (there.distance, there.distance_sigma) == pytest.approx((back.distance, back.distance_sigma))
        if there.angle is not None and back.angle is not None:
            assert there.angle == pytest.approx(-back.angle)


def test_a_thing_has_no_distance_from_itself(solved: tuple[Estimate, SplineMap]) -> None:
    estimate, splines = solved
    assert measure(estimate, splines, factorised(estimate), PickedPose(2), PickedPose(2)) == Measurement(0.0, None)


@pytest.mark.parametrize("picked", [PickedPose(99), PickedPlace(99, 0.1), PickedControlPoint(0, 99)])
def test_what_was_not_solved_is_named(solved: tuple[Estimate, SplineMap], picked: Picked) -> None:
    with pytest.raises(SolverError, match="99"):
        thing_of(*solved, picked)


def test_a_place_on_a_wall_is_less_sure_by_what_its_curve_leaves_out(solved: tuple[Estimate, SplineMap]) -> None:
    estimate, splines = solved
    factor, pair = factorised(estimate), (PickedPose(1), PickedPlace(0, 0.7))
    straying = SplineMap(tuple(replace(spline, left_out=1e-2) for spline in splines))
    before, after = (measure(estimate, each, factor, *pair) for each in (splines, straying))
    assert before.distance_sigma is not None
    assert after.distance_sigma is not None
    place = splines[0].curve(np.array([0.7]))[0]
    towards = (place - estimate.poses[1, :2]) / before.distance
    across = float(towards @ splines[0].curve.normals(np.array([0.7]))[0])
    assert after.distance_sigma**2 - before.distance_sigma**2 == pytest.approx(1e-2 * across**2)
