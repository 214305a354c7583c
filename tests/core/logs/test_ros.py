"""ROS recordings of every format: scans, odometry from messages or transforms, mounting, and everything unusual."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam.errors import LogError
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog

NewBag = Callable[[str], Any]


def has_note(log: ScanLog, *words: str) -> bool:
    """Whether one sentence holds all the words."""
    return any(all(word in note for word in words) for note in log.notes)


def test_a_drive_is_read_as_written(bag, tmp_path: Path) -> None:
    bag.drive(10)
    log = open_log(bag.write(tmp_path))
    assert isinstance(log, ScanLog) and len(log) == 10 and log.notes == ()
    assert np.allclose(log.times, 100 + 0.1 * np.arange(10))
    assert log.odometry is not None and np.allclose(log.odometry[:, 0], 0.1 * np.arange(10))
    scan = log[4]
    assert scan.index == 4 and scan.stamp == pytest.approx(100.4)
    assert np.allclose(scan.ranges, [1, 2, 3]) and np.allclose(scan.bearings, [-0.5, 0, 0.5])
    assert (scan.range_min, scan.range_max) == pytest.approx((0.1, 10.0))
    assert np.allclose(scan.pose_robot_sensor, (0.1, 0, 0))


def test_a_single_file_whatever_its_suffix(bag, tmp_path: Path) -> None:
    bag.drive(3)
    file = bag.write_file(tmp_path)
    assert len(open_log(file)) == 3
    assert len(open_log(file.rename(tmp_path / "my # log?.txt"))) == 3


def test_scans_between_odometry_messages(bag, tmp_path: Path) -> None:
    bag.odometry(0.0, (0, 0, 3.0))
    bag.scan(0.5)
    bag.odometry(1.0, (2, 4, -3.0))
    bag.scan(1.0)
    log = open_log(bag.write(tmp_path))
    assert log.odometry is not None and np.allclose(log.odometry[0], (1, 2, np.pi))
    assert log.records.stamps.tolist() == [0.0, 0.5, 1.0]
    assert log.records.scan_of_record.tolist() == [-1, 0, 1]


def test_odometry_and_mounting_from_transforms(bag, tmp_path: Path) -> None:
    bag.transform(0.0, "base_footprint", "base_link", (0.0, 0.0, 0.0), topic="/tf_static")
    bag.transform(0.0, "base_link", "laser", (0.2, 0.1, np.pi / 2), topic="/tf_static")
    for i in range(5):
        bag.transform(1.0 + i, "/odom", "base_footprint", (i, 0, 0.1 * i))
        bag.transform(1.0 + i, "map", "odom", (0, 0.1 * i, 0))
        bag.scan(1.5 + i)
    log = open_log(bag.write(tmp_path))
    assert log.odometry is not None and np.allclose(log.odometry[:4, 0], [0.5, 1.5, 2.5, 3.5])
    assert np.allclose(log[0].pose_robot_sensor, (0.2, 0.1, np.pi / 2))
    assert has_note(log, "TF odom → base_footprint")


def test_upside_down_laser_is_turned_over(bag, tmp_path: Path) -> None:
    bag.transform(0.0, "base_link", "laser", (0.2, 0.0, np.pi / 2), topic="/tf_static", upside_down=True)
    bag.scan(1.0)
    log = open_log(bag.write(tmp_path))
    scan = log[0]
    assert np.allclose(scan.bearings, [-0.5, 0, 0.5]) and np.allclose(scan.ranges, [3, 2, 1])
    assert np.allclose(scan.pose_robot_sensor, (0.2, 0.0, np.pi / 2)) and has_note(log, "upside down")


def test_without_a_transform_the_laser_stands_at_the_centre(bag, tmp_path: Path) -> None:
    for i in range(3):
        bag.odometry(1.0 + i, (i, 0, 0))
        bag.scan(1.0 + i)
    bag.transform(1.0, "base_link", "camera", (1, 0, 0))
    log = open_log(bag.write(tmp_path))
    assert np.allclose(log[0].pose_robot_sensor, 0)
    assert has_note(log, "No transform joins laser and base_link", "centre")


def test_mounting_on_another_frame_than_that_of_odometry(bag, tmp_path: Path) -> None:
    bag.transform(0.0, "base_link", "laser", (0.2, 0.0, 0.0), topic="/tf_static")
    for i in range(3):
        bag.odometry(1.0 + i, (i, 0, 0), base="base_footprint")
        bag.scan(1.0 + i)
    log = open_log(bag.write(tmp_path))
    assert np.allclose(log[0].pose_robot_sensor, (0.2, 0, 0))
    assert has_note(log, "No transform joins laser and base_footprint", "on base_link")


def test_descending_bearings_are_flipped(bag, tmp_path: Path) -> None:
    bag.scan(1.0, angle_min=0.5, angle_increment=-0.5)
    scan = open_log(bag.write(tmp_path))[0]
    assert np.allclose(scan.bearings, [-0.5, 0, 0.5]) and np.allclose(scan.ranges, [3, 2, 1])


def test_missing_odometry(bag, tmp_path: Path) -> None:
    bag.scan(1.0)
    log = open_log(bag.write(tmp_path))
    assert log.odometry is None and log.odometry_at(1.0) is None and has_note(log, "no odometry", "scan matching")


def test_odometry_that_never_moves_is_missing(bag, tmp_path: Path) -> None:
    for i in range(4):
        bag.odometry(i, (0, 0, 0))
        bag.scan(i)
    log = open_log(bag.write(tmp_path))
    assert log.odometry is None and has_note(log, "never moves", "missing")


def test_odometry_of_another_time_is_missing(bag, tmp_path: Path) -> None:
    for i in range(4):
        bag.odometry(1000 + i, (i, 0, 0))
        bag.scan(i + 1)
    log = open_log(bag.write(tmp_path))
    assert log.odometry is None and has_note(log, "no time in common")


def test_odometry_that_covers_a_part(bag, tmp_path: Path) -> None:
    for i in range(10):
        bag.scan(2 * i)
    for i in range(5):
        bag.odometry(2 * i, (i, 0, 0))
    log = open_log(bag.write(tmp_path))
    assert log.odometry is not None and np.allclose(log.odometry[5:, 0], 4) and has_note(log, "covers only 50%")


def test_truth_topic_is_truth_and_not_odometry(bag, tmp_path: Path) -> None:
    bag.drive(4)
    for i in range(8):
        bag.odometry(100 + 0.1 * i, (i, 1, 0), topic="/ground_truth/pose")
    log = open_log(bag.write(tmp_path))
    assert log.truth is not None and np.allclose(log.truth, [(i, 1, 0) for i in range(4)], atol=1e-5)
    assert log.odometry is not None and np.allclose(log.odometry[:, 1], 0)


def test_two_odometry_topics(bag, tmp_path: Path) -> None:
    bag.drive(5)
    bag.odometry(100.0, (7, 7, 0), topic="/wheel")
    log = open_log(bag.write(tmp_path))
    assert log.odometry is not None and np.allclose(log.odometry[:, 1], 0) and has_note(log, "/odom", "/wheel")


def test_two_laser_topics(bag, tmp_path: Path) -> None:
    bag.scan(0.5, topic="/rear", ranges=[5.0, 5.0, 5.0])
    for i in range(3):
        bag.scan(1.0 + i, topic="/front")
    path = bag.write(tmp_path)
    log = open_log(path)
    assert len(log) == 3 and has_note(log, "/front (3)", "most scans", "/rear (1)")
    rear = open_log(path, topic="/rear")
    assert len(rear) == 1 and np.allclose(rear[0].ranges, 5) and has_note(rear, "asked for", "/front (3)")
    with pytest.raises(LogError, match="no laser topic /left: its laser topics are /front, /rear"):
        open_log(path, topic="/left")


def test_recording_without_scans(bag, tmp_path: Path) -> None:
    bag.odometry(1.0, (0, 0, 0))
    path = bag.write(tmp_path)
    with pytest.raises(LogError, match=r"holds no sensor_msgs/LaserScan, only nav_msgs/msg/Odometry"):
        open_log(path)
    with pytest.raises(LogError, match="it has no laser topic"):
        open_log(path, topic="/scan")


def test_changing_beam_counts(bag, tmp_path: Path) -> None:
    bag.scan(1.0)
    bag.scan(2.0, ranges=[1.0, 2.0])
    log = open_log(bag.write(tmp_path))
    assert [len(scan.bearings) for scan in log] == [3, 2] and has_note(log, "number of beams changes")


def test_readings_that_are_no_measurement(bag, tmp_path: Path) -> None:
    bag.scan(1.0, ranges=[float("nan"), float("inf"), -1.0, 0.0, 0.05, 5.0, 10.0, 11.0], range_max=10.0)
    log = open_log(bag.write(tmp_path))
    assert log[0].valid.tolist() == [False] * 5 + [True] + [False] * 2
    assert log[0].no_return.tolist() == [False, True] + [False] * 4 + [True] * 2
    assert has_note(log, "2 readings", "not a number")


def test_scans_that_cannot_be_used_are_left_out(bag, tmp_path: Path) -> None:
    bag.scan(1.0, ranges=[])
    bag.scan(2.0, angle_increment=0.0)
    bag.scan(3.0, angle_min=float("nan"))
    bag.scan(4.0)
    log = open_log(bag.write(tmp_path))
    assert len(log) == 1 and has_note(log, "3 messages on /scan are left out", "no readings")


def test_error_tells_why_no_scan_can_be_used(bag, tmp_path: Path) -> None:
    bag.scan(2.0, angle_increment=0.0)
    with pytest.raises(LogError, match="none of the 1 scans on /scan can be used: its angle_increment is 0 rad"):
        open_log(bag.write(tmp_path))


def test_damaged_payloads_are_left_out(bag, tmp_path: Path) -> None:
    bag.drive(4)
    topic, kind, recorded, _ = bag.messages[4]
    bag.messages[4] = (topic, kind, recorded, b"\x00\x01\x00\x00\xff\xff")
    log = open_log(bag.write(tmp_path))
    assert len(log) == 3 and has_note(log, "1 messages on /scan", "payload is damaged")


def test_time_that_steps_backwards(bag, tmp_path: Path) -> None:
    stamps = [1.0, 2.0, 1.5, 3.0]
    for i, stamp in enumerate(stamps):
        bag.scan(stamp, recorded=10.0 + i)
    log = open_log(bag.write(tmp_path))
    assert [scan.stamp for scan in log] == stamps and np.all(np.diff(log.times) > 0)
    assert has_note(log, "steps backwards 1 times", "scans keep the order of recording")


def test_duplicate_stamps(bag, tmp_path: Path) -> None:
    for i, stamp in enumerate([1.0, 2.0, 2.0, 3.0]):
        bag.scan(stamp, recorded=10.0 + i)
    log = open_log(bag.write(tmp_path))
    assert np.all(np.diff(log.times) > 0) and has_note(log, "1 scans repeat the stamp")


def test_scans_without_stamps_use_the_time_of_recording(bag, tmp_path: Path) -> None:
    for i in range(3):
        bag.scan(0.0, recorded=50.0 + i)
        bag.odometry(50.0 + i, (i, 0, 0))
    log = open_log(bag.write(tmp_path))
    assert log.records.stamps.tolist() == [50.0, 51.0, 52.0] and has_note(log, "no stamps")


def test_scans_are_read_after_the_file_is_gone(bag, tmp_path: Path) -> None:
    bag.drive(3)
    file = bag.write_file(tmp_path)
    log = open_log(file)
    file.unlink()
    assert np.allclose(log[2].ranges, [1, 2, 3])


def test_progress_rises_to_one(bag, tmp_path: Path) -> None:
    bag.drive(3)
    seen: list[float] = []
    open_log(bag.write(tmp_path), progress=seen.append)
    assert len(seen) > 1 and seen == sorted(seen) and seen[-1] == 1.0


def test_the_first_of_several_echoes_counts(bag, tmp_path: Path) -> None:
    for k in range(3):
        bag.echoes(100.0 + k, [(1.5, 4.0), (2.5,), (), (11.0,)])
    log = open_log(bag.write(tmp_path))
    assert len(log) == 3
    assert np.allclose(log[1].ranges[:2], [1.5, 2.5])
    assert log[1].valid.tolist() == [True, True, False, False]
    assert log[1].no_return.tolist() == [False, False, True, True]
    assert np.allclose(log[1].bearings, [-0.5, 0.0, 0.5, 1.0])
