"""Worlds: exact ray casting against dense polylines, and a drive that keeps clear of everything."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import Float

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.lab.world import World, arc_ranges, box_ranges, line_ranges
from bspline_slam.lab.world_file import open_world

WORLDS = ["corridor", "office", "three_splines"]


def fan(count: int, offset: float = 0.0) -> Float[np.ndarray, "m 2"]:
    """Directions all around."""
    angle = offset + 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def chords(points: Float[np.ndarray, "s 2"]) -> Float[np.ndarray, "l 2 2"]:
    """The straight lines between neighbouring points."""
    return np.stack([points[:-1], points[1:]], 1)


def by_hand(
    lines: Float[np.ndarray, "l 2 2"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m"]:
    """Ranges by solving the 2 × 2 system of every ray and every line; NaN for rays that graze the end of a line."""
    reach = np.full(len(directions), np.inf)
    for i, ray in enumerate(directions):
        systems = np.stack([np.broadcast_to(ray, (len(lines), 2)), lines[:, 0] - lines[:, 1]], -1)
        t, s = np.linalg.solve(systems, (lines[:, 0] - origin)[..., None])[..., 0].T
        ahead = t > 0
        reach[i] = np.min(t, where=ahead & (s >= 0) & (s <= 1), initial=np.inf)
        if np.any(ahead & (np.minimum(np.abs(s), np.abs(s - 1)) < 1e-6)):
            reach[i] = np.nan
    return reach


def assert_same_ranges(
    exact: Float[np.ndarray, "m"], dense: Float[np.ndarray, "m"], tolerance: float, differing: float = 0.0
) -> None:
    """Equal within the tolerance, but for a share of rays that one of them lets pass beside a tangent or an end."""
    same = np.isclose(exact, dense, atol=tolerance) | np.isnan(dense)
    assert np.mean(~same) <= differing


@given(st.integers(0, 2**32 - 1))
def test_lines_are_hit_where_the_two_by_two_system_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lines, origin = rng.uniform(-5, 5, (12, 2, 2)), rng.uniform(-5, 5, 2)
    directions = fan(64, rng.uniform(0, 1))
    assert_same_ranges(line_ranges(lines, origin, directions), by_hand(lines, origin, directions), 1e-9)


@given(st.integers(0, 2**32 - 1))
def test_arcs_are_hit_where_their_dense_polyline_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    radius, start = rng.uniform(0.3, 3), rng.uniform(-np.pi, np.pi)
    sweep = rng.uniform(0.3, 2 * np.pi) * rng.choice([-1, 1])
    angle = start + np.linspace(0, sweep, 2000)
    centre, origin = rng.uniform(-3, 3, 2), rng.uniform(-5, 5, 2)
    points = centre + radius * np.stack([np.cos(angle), np.sin(angle)], -1)
    directions = fan(90, rng.uniform(0, 1))
    exact = arc_ranges(np.array([[*centre, radius, start, sweep]]), origin, directions)
    assert_same_ranges(exact, line_ranges(chords(points), origin, directions), 2e-3, differing=3 / 90)


@given(st.floats(-10, 10), st.floats(-np.pi, np.pi))
def test_a_ray_from_the_middle_of_a_circle_has_its_radius(x: float, direction: float) -> None:
    circle = np.array([[x, 1.0, 2.5, 0.0, 2 * np.pi]])
    ray = np.array([[np.cos(direction), np.sin(direction)]])
    assert arc_ranges(circle, np.array([x, 1.0]), ray) == pytest.approx(2.5)


@given(st.integers(0, 2**32 - 1))
def test_the_box_is_entered_before_anything_in_it_is_hit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-2, 2, (7, 2))
    curve = BSpline(3, clamped_knots(7), points)
    origin, directions = rng.uniform(-4, 4, 2), fan(72, rng.uniform(0, 1))
    hits, _ = curve.ray_hits(origin, directions)
    hit = np.isfinite(hits)
    assert np.all(box_ranges(points, origin, directions)[hit] <= hits[hit])


def test_the_box_has_no_gap_along_the_axes() -> None:
    points, origin = np.array([[1.0, -1.0], [2.0, 0.0], [1.5, 1.0]]), np.zeros(2)
    along_axes = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    assert box_ranges(points, origin, along_axes) == pytest.approx([1.0, np.inf, np.inf])


def dense_lines(world: World) -> Float[np.ndarray, "l 2 2"]:
    """The whole world as short straight lines."""
    arcs = []
    for x, y, radius, start, sweep in world.arcs:
        angle = start + np.linspace(0, sweep, max(int(abs(sweep) * radius / 0.005), 200))
        arcs.append(chords(np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], -1)))
    curves = [chords(spline.sample(0.005)[1]) for spline in world.splines]
    return np.concatenate([world.lines, *arcs, *curves])


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_looks_like_its_dense_polyline_from_everywhere_on_the_drive(name: str) -> None:
    world = open_world(name)
    lines, directions = dense_lines(world), fan(120, 0.01)
    _, poses = world.drive.poses(world.drive.scan_period)
    viewpoints = poses[:: max(len(poses) // 12, 1), :2]
    exact = np.array([world.cast(viewpoint, directions) for viewpoint in viewpoints])
    dense = np.array([line_ranges(lines, viewpoint, directions) for viewpoint in viewpoints])
    assert_same_ranges(exact.ravel(), dense.ravel(), 5e-3, differing=0.005)


@pytest.mark.parametrize("name", WORLDS)
def test_the_drive_keeps_half_a_metre_from_everything_and_crosses_nothing(name: str) -> None:
    world = open_world(name)
    _, points = world.drive.path.sample(0.2)
    around = fan(60)
    for here, there in pairwise(points):
        step = there - here
        way = float(np.linalg.norm(step))
        directions = np.vstack([around, step[None] / way])
        ranges = world.cast(here, directions)
        assert ranges.min() > 0.5 and ranges[-1] > way


def test_the_drive_through_the_office_comes_back_to_its_start() -> None:
    drive = open_world("office").drive
    _, poses = drive.poses(drive.scan_period)
    way = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1).sum()
    assert len(poses) >= 400 and way > 100
    assert np.linalg.norm(poses[-1, :2] - poses[0, :2]) < 1.0
