"""A pose for every record, TUM files there and back, and poses at stamps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.scan import Records, increasing_times


def drive(rng: np.random.Generator, count: int) -> np.ndarray:
    """Poses of a robot that wanders."""
    steps = np.stack([rng.uniform(0.0, 0.3, count), rng.normal(0.0, 0.02, count), rng.normal(0.0, 0.1, count)], -1)
    poses = [np.zeros(3)]
    for step in steps[1:]:
        poses.append(se2.compose(poses[-1], step))
    return np.array(poses)


def records_with(odometry: np.ndarray | None, is_scan: np.ndarray, stamps: np.ndarray | None = None) -> Records:
    stamps = np.arange(len(is_scan), dtype=float) if stamps is None else stamps
    return Records(stamps, increasing_times(stamps), odometry, np.where(is_scan, np.cumsum(is_scan) - 1, -1))


def assert_same_poses(a: np.ndarray, b: np.ndarray, atol: float = 1e-9) -> None:
    np.testing.assert_allclose(a[:, :2], b[:, :2], atol=atol)
    np.testing.assert_allclose(np.exp(1j * a[:, 2]), np.exp(1j * b[:, 2]), atol=atol)


@given(st.integers(0, 2**32 - 1), st.integers(2, 40))
def test_scans_keep_their_poses_and_perfect_odometry_fills_the_rest_exactly(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    odometry = drive(rng, count)
    is_scan = rng.random(count) < 0.4
    is_scan[rng.integers(count)] = True
    world = np.array([3.0, -2.0, 1.0])
    truth = se2.compose(world, odometry)
    trajectory = Trajectory.from_scan_poses(records_with(odometry, is_scan), truth[is_scan])
    assert_same_poses(trajectory.poses, truth)


@given(st.integers(0, 2**32 - 1))
def test_whatever_odometry_says_the_scans_keep_their_poses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    is_scan = np.arange(20) % 3 == 0
    poses = drive(rng, 20)[is_scan]
    trajectory = Trajectory.from_scan_poses(records_with(drive(rng, 20), is_scan), poses)
    assert_same_poses(trajectory.poses[is_scan], poses)


def test_the_closing_difference_is_spread_evenly_over_the_records() -> None:
    odometry = np.stack([np.array([0.0, 1.0, 1.0, 3.0, 4.0]), np.zeros(5), np.zeros(5)], -1)
    is_scan = np.array([True, False, False, False, True])
    scans = np.array([[0.0, 0.0, 0.0], [4.4, 0.0, 0.0]])
    trajectory = Trajectory.from_scan_poses(records_with(odometry, is_scan), scans)
    np.testing.assert_allclose(trajectory.poses[:, 0], [0.0, 1.1, 1.2, 3.3, 4.4], atol=1e-9)


def test_records_outside_the_scans_hang_on_the_nearest_one_by_odometry() -> None:
    odometry = np.stack([np.arange(4.0), np.zeros(4), np.zeros(4)], -1)
    is_scan = np.array([False, True, False, False])
    trajectory = Trajectory.from_scan_poses(records_with(odometry, is_scan), np.array([[0.0, 5.0, np.pi / 2]]))
    np.testing.assert_allclose(trajectory.poses[:, :2], [[0, 4], [0, 5], [0, 6], [0, 7]], atol=1e-9)


def test_a_log_without_odometry_is_interpolated_in_time() -> None:
    is_scan = np.array([True, False, True])
    scans = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 1.0]])
    stamps = np.array([0.0, 0.5, 2.0])
    trajectory = Trajectory.from_scan_poses(records_with(None, is_scan, stamps), scans)
    np.testing.assert_allclose(trajectory.poses[1], [0.5, 0.0, 0.25])


def test_scans_not_yet_read_are_filled_by_odometry() -> None:
    odometry = np.stack([np.arange(4.0), np.zeros(4), np.zeros(4)], -1)
    trajectory = Trajectory.from_scan_poses(records_with(odometry, np.ones(4, bool)), np.array([[0.0, 1.0, 0.0]]))
    np.testing.assert_allclose(trajectory.poses[:, :2], [[0, 1], [1, 1], [2, 1], [3, 1]])


@given(st.integers(0, 2**32 - 1))
def test_tum_there_and_back_in_file_order(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    rng = np.random.default_rng(seed)
    path = tmp_path_factory.mktemp("tum") / "trajectory.tum"
    stamps = 976052857.0 + rng.permutation(np.round(rng.uniform(0, 100, 12), 6))
    written = Trajectory(stamps, drive(rng, 12))
    written.to_tum(path)
    read = Trajectory.from_tum(path)
    np.testing.assert_allclose(read.stamps, stamps, atol=1e-6)
    assert_same_poses(read.poses, written.poses, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "t.tum: holds no poses"),
        ("# only a comment\n", "t.tum: holds no poses"),
        ("# header\n1 2 3\n", "t.tum:2: a pose is"),
        ("1 2 3 0 0 0 0 one\n", "t.tum:1: a pose is"),
    ],
)
def test_files_that_are_no_trajectory(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "t.tum").write_text(text)
    with pytest.raises(LogError, match=sentence):
        Trajectory.from_tum(tmp_path / "t.tum")


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"gone.tum: is not a readable trajectory"):
        Trajectory.from_tum(tmp_path / "gone.tum")


def test_poses_at_stamps() -> None:
    stamps = np.array([0.0, 1.0, 1.0, 4.0, 3.0])
    poses = np.stack([np.arange(5.0), np.zeros(5), np.zeros(5)], -1)
    trajectory = Trajectory(stamps, poses)
    found = trajectory.at(np.array([0.0, 0.25, 1.0, 3.0, 3.00005, 4.0, -0.1, 9.0]))
    np.testing.assert_allclose(found[:6, 0], [0.0, 0.25, 1.0, 4.0, 4.0, 3.0])
    assert np.isnan(found[6:]).all()


@given(st.integers(0, 2**32 - 1), st.integers(1, 30))
def test_every_record_is_found_by_its_own_stamp(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    stamps = rng.permutation(np.round(rng.uniform(0, 5, count), 1))
    trajectory = Trajectory(stamps, drive(rng, count))
    record, off = trajectory.nearest(stamps)
    np.testing.assert_array_equal(off, 0.0)
    np.testing.assert_array_equal(record, [np.flatnonzero(stamps == stamp)[0] for stamp in stamps])
