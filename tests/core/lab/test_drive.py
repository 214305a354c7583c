"""Drives: the path under the way points, and the limits that the robot keeps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.lab.drive import SPACING, Drive


def drive(rng: np.random.Generator, count: int = 8) -> Drive:
    """A winding drive."""
    way_points = np.stack([1.5 * np.arange(count), rng.uniform(-1.5, 1.5, count)], -1)
    return Drive(way_points, speed=0.6, turn_rate=0.7, acceleration=0.4, scan_period=0.5)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_it_starts_at_the_first_way_point_and_keeps_its_limits(seed: int) -> None:
    here = drive(np.random.default_rng(seed))
    period = 0.2
    reached_in_one_sample = np.sqrt(2 * here.acceleration * SPACING)
    times, poses = here.poses(period)
    steps = se2.between(poses[:-1], poses[1:])
    velocity = np.linalg.norm(steps[:, :2], axis=1) / period
    assert np.allclose(np.diff(times), period)
    assert np.allclose(poses[0, :2], here.way_points[0])
    assert np.linalg.norm(poses[-1, :2] - here.way_points[-1]) < here.speed * period
    assert velocity.max() <= here.speed * 1.001
    assert np.abs(steps[:, 2]).max() <= here.turn_rate * period * 1.02
    assert np.abs(np.diff(velocity)).max() <= here.acceleration * period + reached_in_one_sample
    assert max(velocity[0], velocity[-1]) <= 2 * here.acceleration * period


@given(st.integers(0, 2**32 - 1))
def test_the_robot_looks_where_it_goes(seed: int) -> None:
    _, poses = drive(np.random.default_rng(seed)).poses(0.02)
    steps = se2.between(poses[:-1], poses[1:])
    moving = np.linalg.norm(steps[:, :2], axis=1) > 1e-4
    assert np.abs(np.arctan2(steps[moving, 1], steps[moving, 0])).max() < 0.05


def test_way_points_on_a_line_make_a_straight_drive() -> None:
    straight = Drive(np.stack([np.arange(6.0), np.full(6, 2.0)], -1), 0.5, 0.5, 0.5, 0.4)
    times, poses = straight.poses(0.1)
    assert poses[:, 1] == pytest.approx(2.0) and poses[:, 2] == pytest.approx(0.0)
    assert times[-1] == pytest.approx(5.0 / 0.5 + 0.5 / 0.5, abs=0.15)
