"""CARMEN logs: which lines make a scan, where the beams point, and what is said of everything unusual."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog

Write = Callable[..., Path]


def has_note(log: ScanLog, *words: str) -> bool:
    """Whether one sentence holds all the words."""
    return any(all(word in note for word in words) for note in log.notes)


def test_a_drive_is_read_as_written(carmen, write_lines: Write) -> None:
    log = open_log(write_lines(["# a comment", *carmen.drive(10)]))
    assert isinstance(log, ScanLog)
    assert (log.name, len(log)) == ("drive.log", 10)
    assert np.allclose(log.times, 10 + 0.1 * np.arange(10))
    assert log.odometry is not None and np.allclose(log.odometry[:, 0], 0.1 * np.arange(10))
    assert np.allclose(log[3].ranges, 2.0 + 0.01 * np.arange(180))
    assert [scan.index for scan in log] == list(range(10))
    assert log[-1].stamp == pytest.approx(10.9)


def test_odometry_between_scans_is_a_record_of_its_own(carmen, write_lines: Write) -> None:
    lines = [carmen.flaser(0.0), carmen.odom(1.0, (1, 0, 0)), carmen.flaser(2.0, (4, 0, 0))]
    log = open_log(write_lines(lines))
    assert log.records.scan_of_record.tolist() == [0, -1, 1]
    assert log.records.stamps.tolist() == [0.0, 1.0, 2.0]
    pose = log.odometry_at(1.5)
    assert pose is not None and np.allclose(pose, (2.5, 0, 0))
    assert [log.index_at(time) for time in (-5.0, 0.0, 1.9, 2.0, 9.0)] == [0, 0, 0, 1, 1]


@pytest.mark.parametrize(("beams", "last"), [(180, 89.0), (181, 90.0), (360, 89.5), (361, 90.0)])
def test_half_turn_lasers(beams: int, last: float, carmen, write_lines: Write) -> None:
    scan = open_log(write_lines([carmen.flaser(0.0, readings=[2.0] * beams)]))[0]
    assert np.rad2deg(scan.bearings[[0, -1]]) == pytest.approx([-90.0, last])
    assert np.all(np.diff(scan.bearings) > 0)


@pytest.mark.parametrize("remissions", [0, 5])
def test_robotlaser_says_its_field_of_view(remissions: int, carmen, write_lines: Write) -> None:
    lines = [carmen.robotlaser(t, [1.0, 2.0, 3.0, 4.0, 30.0], -0.5, 0.25, 30.0, remissions) for t in (1.0, 2.0)]
    log = open_log(write_lines(lines))
    scan = log[0]
    assert np.allclose(scan.bearings, [-0.5, -0.25, 0.0, 0.25, 0.5])
    assert scan.range_max == 30.0 and scan.no_return.tolist() == [False] * 4 + [True]
    assert np.allclose(scan.pose_robot_sensor, se2.between(np.array([1, 2, 0.5]), np.array([1.2, 2, 0.5])), atol=1e-9)
    assert has_note(log, "no FLASER", "ROBOTLASER1")


def test_robotlaser_that_turns_clockwise_is_flipped(carmen, write_lines: Write) -> None:
    scan = open_log(write_lines([carmen.robotlaser(1.0, [1.0, 2.0, 3.0], 0.5, -0.5, 30.0)]))[0]
    assert np.allclose(scan.bearings, [-0.5, 0.0, 0.5]) and scan.ranges.tolist() == [3.0, 2.0, 1.0]


def test_flaser_is_the_main_laser(carmen, write_lines: Write) -> None:
    rear = [carmen.flaser(5.0 + i, (i, 0, 0), readings=[1.0] * 180, tag="RLASER") for i in range(20)]
    path = write_lines([*carmen.drive(3), *rear])
    log = open_log(path)
    assert len(log) == 3 and has_note(log, "20 RLASER", "left out")
    assert len(open_log(path, topic="RLASER")) == 20
    with pytest.raises(LogError, match=r"no laser topic /scan: its lasers are FLASER, RLASER"):
        open_log(path, topic="/scan")


def test_rear_laser_alone_is_used_and_looks_back(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([carmen.flaser(i, (i, 0, 0), tag="RLASER") for i in range(3)]))
    assert len(log) == 3 and has_note(log, "no FLASER", "RLASER")
    assert abs(log[0].pose_robot_sensor[2]) == pytest.approx(np.pi)


def test_mounting_is_the_offset_between_laser_and_odometry(carmen, write_lines: Write) -> None:
    mounting = np.array([0.2, -0.05, 0.1])
    poses = [np.array([0.5 * i, 0.1 * i, 0.3 * i]) for i in range(8)]
    lines = [carmen.flaser(i, pose, laser=se2.compose(pose, mounting)) for i, pose in enumerate(poses)]
    assert np.allclose(open_log(write_lines(lines))[2].pose_robot_sensor, mounting, atol=1e-3)


def test_mounting_from_parameters_where_the_poses_agree(carmen, write_lines: Write) -> None:
    log = open_log(write_lines(["PARAM robot_frontlaser_offset 0.3 robot 0", *carmen.drive()]))
    assert np.allclose(log[0].pose_robot_sensor, (0.3, 0, 0)) and has_note(log, "0.3 m", "PARAM")


def test_corrected_laser_poses_are_no_mounting(carmen, write_lines: Write) -> None:
    lines = [carmen.flaser(i, (i, 0, 0), laser=(i, 0.3 * i, 0.05 * i)) for i in range(10)]
    log = open_log(write_lines(lines))
    assert np.allclose(log[0].pose_robot_sensor, 0) and has_note(log, "do not follow")
    assert log.odometry is not None and np.allclose(log.odometry[:, 1], 0)


def test_missing_odometry(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([carmen.flaser(i) for i in range(5)]))
    assert log.odometry is None and log.odometry_at(2.0) is None
    assert has_note(log, "odometry", "missing", "scan matching alone")


def test_odometry_in_odom_lines_alone(carmen, write_lines: Write) -> None:
    lines = [line for i in range(5) for line in (carmen.odom(i, (i, 0, 0)), carmen.flaser(i + 0.5))]
    log = open_log(write_lines(lines))
    assert log.odometry is not None and np.allclose(log.odometry[:4, 0], [0.5, 1.5, 2.5, 3.5])
    assert has_note(log, "interpolated from the ODOM lines")


def test_odometry_in_laser_poses_alone(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([carmen.flaser(i, laser=(i, 0, 0)) for i in range(5)]))
    assert log.odometry is not None and np.allclose(log.odometry[:, 0], range(5))
    assert np.allclose(log[0].pose_robot_sensor, 0) and has_note(log, "laser poses are taken as odometry")


def test_odom_lines_of_another_path_are_left_out(carmen, write_lines: Write) -> None:
    lines = [
        line for i in range(20) for line in (carmen.flaser(i, (0.1 * i, 0, 0)), carmen.odom(i + 0.5, (0.1 * i, 5, 1)))
    ]
    log = open_log(write_lines(lines))
    assert log.records.odometry is not None and np.allclose(log.records.odometry[:, 1], 0)
    assert has_note(log, "ODOM", "another path")


def test_truth_from_truepos(carmen, write_lines: Write) -> None:
    lines = [line for i in range(5) for line in (carmen.truepos(i, (2 * i, 1, 0)), carmen.flaser(i + 0.5, (i, 0, 0)))]
    log = open_log(write_lines(lines))
    assert log.truth is not None and np.allclose(log.truth[:4], [[2 * i + 1, 1, 0] for i in range(4)])


def test_time_that_steps_backwards(carmen, write_lines: Write) -> None:
    stamps = [0.0, 1.0, 0.4, 2.0, 1.9]
    log = open_log(write_lines([carmen.flaser(t, (k, 0, 0)) for k, t in enumerate(stamps)]))
    assert log.records.stamps.tolist() == stamps
    assert [scan.stamp for scan in log] == stamps
    assert np.all(np.diff(log.times) > 0)
    assert has_note(log, "steps backwards 2 times", "0.6 s", "order of recording")


def test_duplicate_stamps(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([carmen.flaser(t, (k, 0, 0)) for k, t in enumerate([0.0, 1.0, 1.0, 1.0, 2.0])]))
    assert np.all(np.diff(log.times) > 0) and has_note(log, "2 records repeat the stamp")


def test_clock_that_was_set_back(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([carmen.flaser(t, (k, 0, 0)) for k, t in enumerate([900.0, 901.0, 5.0, 6.0])]))
    assert np.allclose(np.diff(log.times), 1.0) and has_note(log, "set back 1 times")


def test_changing_beam_counts(carmen, write_lines: Write) -> None:
    lines = [carmen.flaser(i, (i, 0, 0), readings=[2.0] * (181 if i == 1 else 180)) for i in range(4)]
    log = open_log(write_lines(lines))
    assert [len(scan.bearings) for scan in log] == [180, 181, 180, 180]
    assert has_note(log, "number of beams changes", "3 with 180", "1 with 181")


def test_unknown_beam_count_is_said(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([carmen.flaser(0.0, readings=[2.0] * 77)]))
    assert has_note(log, "77 beams", "180°") and np.ptp(log[0].bearings) == pytest.approx(np.pi)


def test_readings_that_are_no_measurement(carmen, write_lines: Write) -> None:
    readings = [float("nan"), float("inf"), -1.0, 0.0, *[2.0] * 176]
    log = open_log(write_lines([carmen.flaser(i, (i, 0, 0), readings=readings) for i in range(3)]))
    assert log[0].valid.tolist() == [False] * 4 + [True] * 176
    assert log[0].no_return.tolist() == [False, True] + [False] * 178
    assert has_note(log, "6 readings", "not a number")


def test_readings_beyond_the_limit_are_no_returns(carmen, write_lines: Write) -> None:
    readings = [81.91, 81.83, 81.83, *[2.0] * 177]
    log = open_log(write_lines([carmen.flaser(i, (i, 0, 0), readings=readings) for i in range(5)]))
    assert log[0].no_return.tolist() == [True] * 3 + [False] * 177
    assert log[0].range_max == pytest.approx(81.83) and has_note(log, "81.83 m", "without return")


def test_range_limit_from_parameters(carmen, write_lines: Write) -> None:
    log = open_log(write_lines(["PARAM robot_front_laser_max 20.0", *carmen.drive()]))
    assert log[0].range_max == 20.0


def test_truncated_last_line(carmen, write_lines: Write) -> None:
    lines = carmen.drive(4)
    log = open_log(write_lines([*lines[:3], lines[3][:200]], end=""))
    assert len(log) == 3 and has_note(log, "last line (4)", "cut off", "announces 180 readings")


def test_too_few_readings_in_the_middle(carmen, write_lines: Write) -> None:
    lines = carmen.drive(5)
    words = lines[2].split()
    lines[2] = " ".join([*words[:100], *words[102:]])
    log = open_log(write_lines(lines))
    assert len(log) == 4
    assert has_note(log, "Line 3", "FLASER announces 180 readings, found 178")


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        ("2.01", "two", "a reading that is not a number"),
        ("FLASER 180", "FLASER many", "does not say how many"),
        ("FLASER 180", "FLASER 0", "announces no readings"),
        (" robot", " 1 2 robot", "found 182"),
        ("10.200000 robot", "nan robot", "not a number"),
    ],
)
def test_damaged_lines_are_left_out_and_named(old: str, new: str, rule: str, carmen, write_lines: Write) -> None:
    lines = carmen.drive(5)
    lines[2] = lines[2].replace(old, new, 1)
    log = open_log(write_lines(lines))
    assert len(log) == 4 and has_note(log, "Line 3", rule)


def test_many_damaged_lines_are_counted(carmen, write_lines: Write) -> None:
    lines = [*carmen.drive(3), *["ODOM 1 2"] * 12, *carmen.drive(2)]
    assert has_note(open_log(write_lines(lines)), "12 lines are left out (4, 5,", "…", "ODOM needs 9 values, found 2")


def test_unknown_lines_are_counted(carmen, write_lines: Write) -> None:
    log = open_log(write_lines(["SYNC a", "MARKER b", "SYNC c", *carmen.drive(2), "", "# end"]))
    assert has_note(log, "3 lines of unknown kind", "SYNC (2)", "MARKER (1)")


def test_error_names_line_and_rule_when_no_scan_is_left(carmen, write_lines: Write) -> None:
    with pytest.raises(LogError, match=r"^drive.log:2: FLASER announces 180 readings, found 0.*no other line"):
        open_log(write_lines([carmen.odom(0, (0, 0, 0)), "FLASER 180 1 2 3"]))


def test_log_without_a_scan(carmen, write_lines: Write) -> None:
    with pytest.raises(LogError, match=r"^drive.log: the log holds no laser scan"):
        open_log(write_lines([carmen.odom(i, (i, 0, 0)) for i in range(3)]))


def test_windows_line_ends(carmen, tmp_path: Path) -> None:
    path = tmp_path / "drive.log"
    path.write_bytes("\r\n".join(carmen.drive(3)).encode())
    assert len(open_log(path)) == 3


def test_progress_rises_to_one(carmen, write_lines: Write) -> None:
    seen: list[float] = []
    open_log(write_lines([carmen.odom(i, (i, 0, 0)) for i in range(3000)] + carmen.drive(2)), progress=seen.append)
    assert len(seen) > 2 and seen == sorted(seen) and seen[-1] == 1.0


@pytest.mark.parametrize("laser", [1, 4])
def test_raw_lasers_take_their_poses_from_odometry(laser: int, carmen, write_lines: Write) -> None:
    def raw(stamp: float) -> str:
        return f"RAWLASER{laser} 0 -1.0 2.0 0.5 30 0.01 0 5 1 2 3 4 30 0 {stamp} robot {stamp}"

    lines = [line for k in range(4) for line in (carmen.odom(float(k), (k, 0, 0)), raw(k + 0.5))]
    log = open_log(write_lines([*lines, carmen.odom(4.0, (4, 0, 0))]))
    assert np.allclose(log[2].bearings, [-1.0, -0.5, 0.0, 0.5, 1.0])
    assert log[2].range_max == 30.0
    assert log.odometry is not None and np.allclose(log.odometry[:, 0], [0.5, 1.5, 2.5, 3.5])


def test_a_stamp_alone_ends_a_line_as_well(carmen, write_lines: Write) -> None:
    lines = [" ".join(line.split()[:-2]) for line in carmen.drive(6)]
    log, whole = open_log(write_lines(lines)), open_log(write_lines(carmen.drive(6), name="whole.log"))
    assert np.array_equal(log.times, whole.times)
    assert np.array_equal(log[3].ranges, whole[3].ranges)


def test_readings_of_gmapping(write_lines: Write) -> None:
    readings = " ".join(["2.5"] * 180)
    lines = [f"LASER_READING 180 {readings} {k} 0 0.1 {k + 0.25}" for k in range(4)]
    log = open_log(write_lines(lines))
    assert np.allclose(log.times, 0.25 + np.arange(4))
    assert log.odometry is not None and np.allclose(log.odometry, [[k, 0, 0.1] for k in range(4)])


def test_windows_ends_of_lines_are_ends_of_lines(carmen, write_lines: Write) -> None:
    log = open_log(write_lines([line + "\r" for line in carmen.drive(6)]))
    assert len(log) == 6 and not has_note(log, "left out")
