"""Scans say which beams hit; the time axis always increases; poses are interpolated on it."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.scan import CLOCK_SET_BACK, LaserScan, increasing_times, interpolate_poses

STAMPS = st.lists(st.floats(-1e9, 1e9), max_size=40).map(np.array)
NEAR_STAMPS = st.lists(st.floats(0, 5).map(lambda t: round(t, 1)), min_size=1, max_size=40).map(np.array)


def scan(ranges: list[float], pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> LaserScan:
    bearings = np.linspace(-1.0, 1.0, len(ranges))
    return LaserScan(0, 0.0, np.array(ranges), bearings, 0.1, 10.0, np.array(pose))


def test_each_beam_is_a_hit_or_a_no_return_or_nothing() -> None:
    some = scan([np.nan, np.inf, -np.inf, -1.0, 0.0, 0.1, 5.0, 10.0, 12.0])
    assert some.valid.tolist() == [False] * 6 + [True] + [False] * 2
    assert some.no_return.tolist() == [False, True] + [False] * 5 + [True, True]


@given(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)))
def test_points_stand_where_the_mounting_puts_them(pose: tuple[float, float, float]) -> None:
    some = scan([1.0, np.nan, 3.0], pose)
    in_sensor = some.ranges[:, None] * np.stack([np.cos(some.bearings), np.sin(some.bearings)], -1)
    assert np.allclose(some.points_robot, se2.transform(np.array(pose), in_sensor), equal_nan=True)
    assert some.resolution == 1.0


@given(STAMPS)
def test_times_increase_whatever_the_stamps(stamps: np.ndarray) -> None:
    times = increasing_times(stamps)
    assert len(times) == len(stamps) and np.all(np.diff(times) > 0)


@given(NEAR_STAMPS)
def test_times_stay_near_the_latest_stamp(stamps: np.ndarray) -> None:
    times = increasing_times(stamps)
    latest = np.maximum.accumulate(stamps)
    assert np.all(times >= latest - 1e-9)
    levels = np.unique(latest)
    following = np.append(levels, np.inf)[np.searchsorted(levels, latest) + 1]
    assert np.all(times < following + 1e-9)


@given(NEAR_STAMPS)
def test_increasing_stamps_are_their_own_times(stamps: np.ndarray) -> None:
    ordered = np.unique(stamps)
    assert np.array_equal(increasing_times(ordered), ordered)


def test_a_clock_that_is_set_back_does_not_stop_time() -> None:
    stamps = np.concatenate([np.arange(100.0), np.arange(50.0)])
    assert CLOCK_SET_BACK < 50.0
    assert np.allclose(increasing_times(stamps), np.arange(150.0))


def test_many_equal_stamps_far_from_zero() -> None:
    times = increasing_times(np.array([1.7e9] * 20_000 + [1.7e9 + 1e-3]))
    assert np.all(np.diff(times) > 0) and times[-1] < 1.7e9 + 1.0


def test_poses_between_records() -> None:
    times, poses = np.array([0.0, 1.0, 3.0]), np.array([[0, 0, 3.0], [2, 0, -3.0], [2, 4, -3.0]])
    assert np.allclose(interpolate_poses(times, poses, 2.0), [2, 2, -3.0])
    middle = interpolate_poses(times, poses, 0.5)
    assert np.allclose(middle[:2], [1, 0]) and abs(middle[2]) == np.pi  # the short way round
    held = interpolate_poses(times, poses, np.array([-9.0, 9.0]))
    assert np.allclose(held, poses[[0, -1]])


def test_a_single_pose_holds_for_all_times() -> None:
    pose = np.array([[1.0, 2.0, 3.0]])
    assert np.array_equal(interpolate_poses(np.zeros(1), pose, 7.0), pose[0])
    assert interpolate_poses(np.zeros(1), pose, np.arange(3.0)).shape == (3, 3)
