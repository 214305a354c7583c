"""Tracking: follows the robot with good, biased and no odometry, and says when it is lost."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.motion import MotionConfig
from bspline_slam.front_end.scan_matching import MatchingConfig
from bspline_slam.front_end.tracking import Tracker
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.segmentation import SegmentationConfig
from core.rooms import ROOM, loop_path, room_scan

AROUND = np.concatenate([ROOM[:6], ROOM[6:] - [0.4, 0.4]])
"""The room with its box off the path: inside the box a robot is blocked."""


def tracker() -> Tracker:
    return Tracker(TrackingConfig(distance=0.25), MatchingConfig(), SegmentationConfig(), MotionConfig())


def drifting(path: np.ndarray, yaw: float, scale: float) -> np.ndarray:
    """Odometry that adds `yaw` to every step and scales its length."""
    poses = [np.zeros(3)]
    for step in se2.between(path[:-1], path[1:]):
        poses.append(se2.compose(poses[-1], step * [scale, scale, 1.0] + [0.0, 0.0, yaw]))
    return np.array(poses)


@pytest.mark.parametrize("odometry", ["biased", "none"])
def test_the_path_is_followed(odometry: str) -> None:
    path, rng, one = loop_path(60), np.random.default_rng(5), tracker()
    wheels = drifting(path, 0.02, 0.95) if odometry == "biased" else None
    for k, pose in enumerate(path):
        one.track(room_scan(pose, rng, index=k, walls=AROUND), None if wheels is None else wheels[k])
    off = se2.between(se2.between(path[0], path), one.chain.scan_poses)
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.05
    assert np.percentile(np.abs(off[:, 2]), 95) < 0.02
    assert abs(off[-1, 2]) < 0.01
    kinds = {factor.kind for factor in one.chain.factors}
    assert kinds == ({"matching", "odometry"} if wheels is not None else {"matching"})


def wrong(path: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """Odometry whose every step is multiplied by `factor`."""
    poses = [np.zeros(3)]
    for step in se2.between(path[:-1], path[1:]):
        poses.append(se2.compose(poses[-1], step * factor))
    return np.array(poses)


@pytest.mark.parametrize("factor", [(0, 0, 0), (-1, -1, 1), (1, 1, -1), (-1, -1, -1)])
def test_odometry_that_does_not_fit_is_found_out_and_not_followed(factor: tuple[int, int, int]) -> None:
    """Not after the first steps, that is."""
    path, rng, one = loop_path(90), np.random.default_rng(8), tracker()
    wheels = wrong(path, np.array(factor, dtype=float))
    tracked = [one.track(room_scan(pose, rng, index=k, walls=AROUND), wheels[k]) for k, pose in enumerate(path)]
    off = se2.between(se2.between(path[0], path), one.chain.scan_poses)[3:]
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.06
    assert any(found.unfit for found in tracked)
    assert not any(found.lost for found in tracked)


def test_odometry_that_fits_is_believed_throughout() -> None:
    path, rng, one = loop_path(60), np.random.default_rng(9), tracker()
    wheels = drifting(path, 0.01, 0.95)
    assert not any(
        one.track(room_scan(pose, rng, index=k, walls=AROUND), wheels[k]).unfit for k, pose in enumerate(path)
    )


def test_a_robot_that_creeps_is_followed() -> None:
    """Each step is too small to count as motion, and odometry errs by half."""
    path, rng, one = loop_path(60)[:30], np.random.default_rng(10), tracker()
    slow = se2.interpolate(path[:-1, None], path[1:, None], np.linspace(0, 1, 40, endpoint=False)).reshape(-1, 3)[:600]
    wheels = wrong(slow, np.array([0.5, 0.5, 1.0]))
    for k, pose in enumerate(slow):
        one.track(room_scan(pose, rng, index=k, walls=AROUND), wheels[k])
    off = se2.between(se2.between(slow[0], slow), one.chain.scan_poses)
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.06
    assert len(one.chain.keys) > 3


def test_a_lost_key_scan_is_tied_loosely_where_no_odometry_tells_of_it() -> None:
    path, rng, one = loop_path(30), np.random.default_rng(11), Tracker(
        TrackingConfig(distance=0.1), MatchingConfig(), SegmentationConfig(), MotionConfig()
    )  # fmt: skip
    for k, pose in enumerate(path[:16]):
        scan = room_scan(pose, rng, index=k, walls=AROUND)
        one.track(replace(scan, ranges=np.full(361, np.inf)) if k == 10 else scan, None)
    lost = [key.scan for key in one.chain.keys].index(10)
    tie = next(factor for factor in one.chain.factors if factor.j == lost)
    assert tie.kind == "odometry"
    assert np.abs(tie.sqrt_information).max() <= 2.0
    assert one.chain.keys[lost].travel - one.chain.keys[lost - 1].travel > TrackingConfig().lost_travel


def test_a_blinded_scan_is_lost_and_odometry_carries_on() -> None:
    path, rng, one = loop_path(60), np.random.default_rng(6), tracker()
    for k, pose in enumerate(path[:40]):
        scan = room_scan(pose, rng, index=k, walls=AROUND)
        if 20 <= k < 24:
            scan = replace(scan, ranges=np.where(np.arange(361) % 40 == 0, 0.4, np.inf))
        tracked = one.track(scan, path[k])
        assert tracked.lost == (20 <= k < 24)
    off = se2.between(se2.between(path[0], path[39]), one.chain.scan_poses[-1])
    assert np.hypot(off[0], off[1]) < 0.05


@pytest.mark.parametrize("reach", [0.2, 0.3, 0.5])
def test_who_stands_before_the_laser_and_moves_along_is_no_wall(reach: float) -> None:
    path, rng, one = loop_path(60), np.random.default_rng(6), tracker()
    for k, pose in enumerate(path):
        scan = room_scan(pose, rng, index=k, walls=AROUND)
        if 30 <= k < 42:
            hidden = rng.random(361) < 0.95
            scan = replace(scan, ranges=np.where(hidden, reach + rng.normal(0.0, 0.01, 361), scan.ranges))
        tracked = one.track(scan, path[k])
        assert tracked.lost == (30 <= k < 42)
    off = se2.between(se2.between(path[0], path), one.chain.scan_poses)
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.05


def test_a_blocked_scan_is_lost_however_well_it_fits_where_odometry_tells_of_the_motion() -> None:
    path, rng, one = loop_path(60), np.random.default_rng(12), tracker()
    for k, pose in enumerate(path[:30]):
        scan = room_scan(pose, rng, index=k, walls=AROUND)
        if k == 20:
            scan = replace(scan, ranges=np.minimum(scan.ranges, 0.55))
        assert one.track(scan, path[k]).lost == (k == 20)


def test_a_blocked_scan_is_lost_where_there_is_no_odometry_either() -> None:
    path, rng, one = loop_path(60), np.random.default_rng(12), tracker()
    for k, pose in enumerate(path[:30]):
        scan = room_scan(pose, rng, index=k, walls=AROUND)
        if 20 <= k < 22:
            scan = replace(scan, ranges=np.full(361, 0.4) + rng.normal(0.0, 0.01, 361))
        assert one.track(scan, None).lost == (20 <= k < 22)
    off = se2.between(se2.between(path[0], path[29]), one.chain.scan_poses[-1])
    assert np.hypot(off[0], off[1]) < 0.05


POSTS = np.array(
    [[[1.0, 0.8], [1.0, 1.8]], [[1.0, 1.8], [2.0, 2.8]], [[30.0, 0.8], [30.0, 1.8]], [[30.0, 1.8], [31.0, 0.0]]]
)
"""Little to see, and that far apart."""


@pytest.mark.parametrize(
    ("walls", "steps", "there", "elsewhere"),
    [
        (AROUND, loop_path(60)[:6], AROUND[:, ::-1] * 1.9 - 0.6, True),
        (POSTS, [[x, 1.0, 0.0] for x in (-3.0, -2.8)], POSTS, False),
    ],
)
def test_a_lost_scan_strays_only_if_it_shows_another_place_than_it_should(
    walls: np.ndarray, steps: list[list[float]], there: np.ndarray, elsewhere: bool
) -> None:
    """Not when all that was known is out of range, and what comes into view is new."""
    rng, one, path = np.random.default_rng(13), tracker(), np.array(steps)
    for k, pose in enumerate(path):
        one.track(replace(room_scan(pose, rng, index=k, walls=walls), range_max=8.0), pose)
    pose = path[-1] if elsewhere else np.array([26.0, 1.0, 0.0])
    last = replace(room_scan(pose, rng, index=9, walls=there), range_max=8.0)
    assert one.track(last, se2.compose(pose, np.array([0.3, 0.0, 0.0]))).lost
    assert bool(one.chain.strays) == elsewhere


def test_standing_still_makes_no_key_scans() -> None:
    rng, one, pose = np.random.default_rng(7), tracker(), np.array([2.0, 1.5, 0.0])
    keys = [one.track(room_scan(pose, rng, index=k, walls=AROUND), pose).key for k in range(10)]
    assert keys == [True] + [False] * 9
    assert len(one.chain.scan_poses) == 10


@pytest.mark.parametrize("shown", [np.nan, 0.3])
@pytest.mark.parametrize("wheeled", [True, False])
def test_a_log_that_begins_with_blank_or_blocked_scans_is_followed_from_the_first_that_sees(
    shown: float, wheeled: bool
) -> None:
    path, rng, one, blank = loop_path(60), np.random.default_rng(5), tracker(), 4
    for k, pose in enumerate(path):
        scan = room_scan(pose, rng, index=k, walls=AROUND)
        scan = replace(scan, ranges=np.full_like(scan.ranges, shown)) if k < blank else scan
        one.track(scan, pose if wheeled else None)
    seeing = blank + (0 if np.isnan(shown) else TrackingConfig().patience)
    off = se2.between(se2.between(path[seeing], path), se2.between(one.chain.scan_poses[seeing], one.chain.scan_poses))
    assert np.hypot(off[seeing:, 0], off[seeing:, 1]).max() < 0.08


def test_a_robot_without_odometry_that_stands_in_another_place_is_not_lost_for_ever() -> None:
    rng, one, pose = np.random.default_rng(7), tracker(), np.array([2.0, 1.5, 0.0])
    around = np.linspace(0.0, 2.0 * np.pi, 9) + 0.2
    corners = pose[:2] + 9.0 * np.stack([np.cos(around), np.sin(around)], -1)
    octagon = np.stack([corners[:-1], corners[1:]], 1)
    places = [AROUND] * 6 + [octagon] * (TrackingConfig().patience + 3)
    tracked = [one.track(room_scan(pose, rng, index=k, walls=w, beams=91), None) for k, w in enumerate(places)]
    assert [found.lost for found in tracked[5:]] == [False] + [True] * TrackingConfig().patience + [False] * 3


def corridor(length: float) -> np.ndarray:
    """Walls 2.4 m apart with piers at uneven distances along one side."""
    rng, walls = np.random.default_rng(4), [[[-20.0, y], [length, y]] for y in (-1.2, 1.2)]
    for x in np.cumsum(rng.uniform(2.0, 5.0, int(length / 3))) - 5.0:
        corners = [[x, 1.2], [x, 0.9], [x + 0.5, 0.9], [x + 0.5, 1.2]]
        walls += [list(pair) for pair in pairwise(corners)]
    return np.array(walls)


def test_the_last_place_is_not_taken_again_because_it_is_known_better_than_the_next() -> None:
    """A laser of short range sees little at once of what it saw a long step ago, and walls fit anywhere along them."""
    path = np.array([[3.2 * k, 0.0, 0.0] for k in range(12)])
    rng, one, walls = np.random.default_rng(6), tracker(), corridor(60.0)
    for k, pose in enumerate(path):
        scan = room_scan(pose, rng, index=k, walls=walls)
        one.track(replace(scan, ranges=np.where(scan.ranges < 5.0, scan.ranges, np.inf)), pose)
    assert np.abs(one.chain.scan_poses[:, :2] - path[:, :2]).max() < 0.5


def test_a_jump_of_odometry_does_not_teach_its_bias() -> None:
    path, rng, one = loop_path(60), np.random.default_rng(5), tracker()
    wheels = path.copy()
    wheels[30:] = se2.compose(se2.compose(path[29], np.array([2.5, 0.4, 0.8])), se2.between(path[29], path[30:]))
    for k in range(45):
        one.track(room_scan(path[k], rng, index=k, walls=AROUND), wheels[k])
    off = se2.between(se2.between(path[0], path[:45]), one.chain.scan_poses)
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.06
    assert np.abs(one.wheels.calibration.matrix(one.motion) - np.eye(3))[:, 0].max() < 0.1
