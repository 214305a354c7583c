"""Logs out and in again: every format gives back the scans, the odometry and the truth that were written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bspline_slam.errors import LogError
from bspline_slam.export.logs import log_suffix, truth_path, write_carmen, write_mcap, write_truth
from bspline_slam.lab.simulation import SimulatedLog, simulate
from bspline_slam.lab.world_file import parse_world
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog

WORLD = """{
  "laser": {"field_of_view": %g, "resolution": %g, "range_max": 5, "pose": [0.12, 0, 0]},
  "drive": {"way_points": [[0, 0], [1, 0], [2, 0.5], [2, 2]], "speed": 0.5, "turn_rate": 30, "scan_period": 1},
  "shapes": [{"shape": "polyline", "points": [[-2, -2], [4, -2], [4, 9]]}]
}"""


def drive(field_of_view: float = 180, resolution: float = 1) -> SimulatedLog:
    """A short drive with walls on two sides and nothing on the others."""
    world = parse_world(WORLD % (field_of_view, resolution), "corner.json")
    return simulate(world, rng=np.random.default_rng(2))


def assert_same(read: ScanLog, written: ScanLog, tolerance: float) -> None:
    """The same scans, odometry and truth, within the precision of the format."""
    assert len(read) == len(written)
    assert np.allclose(read.times, written.times, atol=1e-6)
    assert np.array_equal(read.records.scan_of_record >= 0, written.records.scan_of_record >= 0)
    assert read.odometry is not None and written.odometry is not None
    assert read.truth is not None and written.truth is not None
    assert np.allclose(read.odometry, written.odometry, atol=tolerance)
    assert np.allclose(read.truth, written.truth, atol=tolerance)
    for mine, theirs in zip(read, written, strict=True):
        assert np.array_equal(mine.valid, theirs.valid) and np.array_equal(mine.no_return, theirs.no_return)
        assert np.allclose(mine.ranges[mine.valid], theirs.ranges[theirs.valid], atol=tolerance)
        assert np.allclose(mine.bearings, theirs.bearings, atol=1e-5)
        assert np.allclose(mine.pose_robot_sensor, theirs.pose_robot_sensor, atol=tolerance)
        assert mine.range_max == pytest.approx(theirs.range_max)


@pytest.mark.parametrize("name", ["corner.log", "corner.log.gz"])
@pytest.mark.parametrize(("field_of_view", "resolution"), [(180, 1), (180, 0.5), (270, 0.5), (180, 0.25)])
def test_carmen_gives_back_what_was_written(tmp_path: Path, name: str, field_of_view: float, resolution: float) -> None:
    log = drive(field_of_view, resolution)
    assert any(scan.no_return.any() for scan in log)
    write_carmen(log, tmp_path / name)
    write_truth(log, truth_path(tmp_path / name))
    assert_same(open_log(tmp_path / name), log, 2e-6)


@pytest.mark.parametrize(("field_of_view", "resolution"), [(180, 1), (270, 0.25)])
def test_a_bag_gives_back_what_was_written(tmp_path: Path, field_of_view: float, resolution: float) -> None:
    log = drive(field_of_view, resolution)
    write_mcap(log, tmp_path / "corner.mcap")
    write_truth(log, truth_path(tmp_path / "corner.mcap"))
    read = open_log(tmp_path / "corner.mcap")
    assert len(read) == len(log) and np.allclose(read.times, log.times, atol=1e-6)
    assert read.odometry is not None and log.odometry is not None and read.truth is not None and log.truth is not None
    assert np.allclose(read.odometry, log.odometry, atol=1e-6) and np.allclose(read.truth, log.truth, atol=1e-5)
    for mine, theirs in zip(read, log, strict=True):
        assert np.array_equal(mine.valid, theirs.valid)
        assert np.allclose(mine.ranges[mine.valid], theirs.ranges[theirs.valid], atol=1e-6)
        assert np.allclose(mine.bearings, theirs.bearings, atol=1e-5)
        assert np.allclose(mine.pose_robot_sensor, theirs.pose_robot_sensor, atol=1e-6)


def test_a_beam_that_measured_nothing_is_no_free_beam_when_read_again(tmp_path: Path) -> None:
    log = drive()
    ranges = log[0].ranges.copy()
    ranges[5] = np.nan
    damaged = replace(log, scans=(replace(log[0], ranges=ranges), *log.scans[1:]))
    for write, name in ((write_carmen, "a.log"), (write_mcap, "a.mcap")):
        write(damaged, tmp_path / name)
        scan = open_log(tmp_path / name)[0]
        assert not scan.valid[5] and not scan.no_return[5]
        assert np.array_equal(scan.no_return, damaged[0].no_return)


def test_any_log_can_be_written_again(tmp_path: Path) -> None:
    write_carmen(drive(), tmp_path / "a.log")
    write_carmen(open_log(tmp_path / "a.log"), tmp_path / "b.log")
    first, second = open_log(tmp_path / "a.log"), open_log(tmp_path / "b.log")
    for mine, theirs in zip(first, second, strict=True):
        assert np.array_equal(mine.valid, theirs.valid)
        assert np.allclose(mine.ranges[mine.valid], theirs.ranges[theirs.valid])


def test_a_log_without_odometry_stays_without(tmp_path: Path) -> None:
    log = drive()
    bare = replace(log, records=replace(log.records, odometry=None))
    write_mcap(bare, tmp_path / "bare.mcap")
    read = open_log(tmp_path / "bare.mcap")
    assert read.odometry is None and len(read) == len(log)


@pytest.mark.parametrize("write", [write_carmen, write_mcap])
def test_a_log_without_scans_cannot_be_written(tmp_path: Path, write) -> None:
    log = drive()
    empty = replace(log, scans=(), records=replace(log.records, scan_of_record=np.full(len(log.records.stamps), -1)))
    with pytest.raises(LogError, match="has no scans to write"):
        write(empty, tmp_path / "empty")


def test_a_log_without_truth_has_none_to_write(tmp_path: Path) -> None:
    write_carmen(drive(), tmp_path / "a.log")
    with pytest.raises(LogError, match=r"a\.log: has no true poses to write"):
        write_truth(open_log(tmp_path / "a.log"), tmp_path / "a.truth.tum")


@pytest.mark.parametrize(
    ("name", "suffix", "truth"),
    [
        ("office.log.gz", ".log.gz", "office.truth.tum"),
        ("office.log", ".log", "office.truth.tum"),
        ("level.2.mcap", ".mcap", "level.2.truth.tum"),
    ],
)
def test_names_of_truth_files(name: str, suffix: str, truth: str) -> None:
    assert log_suffix(Path(name)) == suffix and truth_path(Path("logs") / name) == Path("logs") / truth
