"""Ranges along beams: their Jacobian by central differences, and against the curve's own ray casting."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.backends.beam_model import GRAZING, predict_ranges
from bspline_slam.bspline import BSpline, uniform_knots

STEP = 1e-6


def wavy(rng: np.random.Generator, count: int = 9) -> BSpline:
    """A wall along x, 3 m ahead, with waves of some decimetres."""
    points = np.column_stack([0.5 * np.arange(count) - 2.0, 3.0 + 0.2 * rng.normal(size=count)])
    return BSpline(3, uniform_knots(0.0, 0.5, count), points)


def beams(rng: np.random.Generator, curve: BSpline, pose: np.ndarray, count: int = 6):
    """Beams at points of the curve, from a sensor beside the robot's middle: origins, directions, ranges, feet."""
    t = rng.uniform(*curve.domain, count)
    origin = np.array([0.3, -0.1])
    rays = se2.transform(se2.inverse(pose), curve(t)) - origin
    ranges = np.linalg.norm(rays, axis=1)
    return np.tile(origin, (count, 1)), rays / ranges[:, None], ranges, t


@given(st.integers(0, 10_000), st.floats(-3.0, 3.0))
def test_jacobian_by_central_differences(seed: int, angle: float) -> None:
    rng = np.random.default_rng(seed)
    curve, pose = wavy(rng), np.array([*rng.normal(size=2) * 0.3, angle])
    origins, directions, _, t = beams(rng, curve, pose)
    found = predict_ranges(curve, pose, origins, directions, t)
    steep = found.meets & (found.incidence > 0.4)
    assume(steep.any())

    def ranges(pose: np.ndarray, control_points: np.ndarray) -> np.ndarray:
        moved = curve.with_control_points(control_points)
        return predict_ranges(moved, pose, origins, directions, t).ranges[steep]

    for axis in range(3):
        step = STEP * np.eye(3)[axis]
        slope = (ranges(pose + step, curve.control_points) - ranges(pose - step, curve.control_points)) / (2 * STEP)
        np.testing.assert_allclose(found.by_pose[steep, axis], slope, rtol=1e-5, atol=1e-6)
    for k in range(len(curve.control_points)):
        for axis in range(2):
            step = np.zeros_like(curve.control_points)
            step[k, axis] = STEP
            ahead, behind = (ranges(pose, curve.control_points + sign * step) for sign in (1, -1))
            place = k - found.first[steep]
            given = np.where(
                (place >= 0) & (place <= 3),
                found.by_points[np.flatnonzero(steep), np.clip(place, 0, 3), axis],
                0.0,
            )
            np.testing.assert_allclose(given, (ahead - behind) / (2 * STEP), rtol=1e-5, atol=1e-6)


@given(st.integers(0, 10_000))
def test_ranges_are_those_of_the_points_hit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve, pose = wavy(rng), np.array([0.1, -0.2, 0.4])
    origins, directions, ranges, t = beams(rng, curve, pose)
    found = predict_ranges(curve, pose, origins, directions, t)
    np.testing.assert_allclose(found.ranges[found.meets], ranges[found.meets], atol=1e-9)
    assert np.all(found.incidence[found.meets] >= GRAZING)


def test_the_search_finds_the_hit_from_half_a_metre_away() -> None:
    rng = np.random.default_rng(0)
    curve = wavy(rng)
    origins, directions, ranges, t = beams(rng, curve, se2.IDENTITY)
    away = np.clip(t + 0.5, *curve.domain)
    found = predict_ranges(curve, se2.IDENTITY, origins, directions, away)
    np.testing.assert_allclose(found.ranges[found.meets], ranges[found.meets], atol=1e-6)
    assert found.meets.sum() >= 4


@pytest.mark.parametrize(
    ("direction", "why"),
    [((0.0, -1.0), "it points away"), ((1.0, 0.1), "it passes the end"), ((-1.0, 0.02), "it hardly comes nearer")],
)
def test_beams_that_say_nothing_are_told(direction: tuple[float, float], why: str) -> None:
    straight = BSpline(3, uniform_knots(0.0, 0.5, 9), np.column_stack([0.5 * np.arange(9) - 2.0, np.full(9, 3.0)]))
    ray = np.array([direction]) / np.hypot(*direction)
    found = predict_ranges(straight, se2.IDENTITY, np.zeros((1, 2)), ray, np.array([1.5]))
    assert not found.meets[0], why


def test_a_grazing_beam_is_told_although_it_hits() -> None:
    straight = BSpline(3, uniform_knots(0.0, 0.5, 60), np.column_stack([0.5 * np.arange(60) - 2.0, np.full(60, 1.0)]))
    ray = np.array([[1.0, 0.1]]) / np.hypot(1.0, 0.1)
    found = predict_ranges(straight, se2.IDENTITY, np.zeros((1, 2)), ray, np.array([11.0]))
    assert found.ranges[0] == pytest.approx(10.0 * np.hypot(1.0, 0.1))
    assert found.incidence[0] < GRAZING
    assert not found.meets[0]
