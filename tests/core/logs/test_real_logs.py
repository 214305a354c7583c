"""Real recordings, when they lie beside the repository."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from bspline_slam.logs import open_log

DATA = Path(__file__).parents[4] / "shared" / "data"


def real(name: str) -> Path:
    """A real log; the test is skipped without it, but never under CI."""
    path = DATA / name
    if not path.exists():
        if os.environ.get("CI") == "true":
            pytest.fail(f"{path} is missing")
        pytest.skip(f"{path} is missing")
    return path


@pytest.mark.parametrize(
    ("name", "scans", "records", "beams", "limit"),
    [
        ("intel-lab.log.gz", 8541, 13631, 180, 81.83),
        ("aces.log.gz", 440, 7374, 180, 50.0),
        ("freiburg-101.log.gz", 292, 4277, 360, 81.83),
    ],
)
def test_carmen_logs(name: str, scans: int, records: int, beams: int, limit: float) -> None:
    log = open_log(real(name))
    assert (len(log), len(log.records.stamps), len(log[0].ranges)) == (scans, records, beams)
    assert log[0].range_max == limit and log.odometry is not None and np.all(np.diff(log.times) > 0)
    sample = [log[index] for index in range(0, scans, scans // 40)]
    assert all(np.all(scan.valid | scan.no_return) for scan in sample)
    assert np.mean([scan.no_return.mean() for scan in sample]) < 0.2
    assert np.array_equal(log[0].pose_robot_sensor, np.zeros(3))


def test_the_intel_log_steps_backwards() -> None:
    log = open_log(real("intel-lab.log.gz"))
    assert any("steps backwards" in note for note in log.notes) and any(
        "repeat the stamp" in note for note in log.notes
    )


@pytest.mark.parametrize(
    ("name", "scans", "beams", "limit"),
    [("laser_scan_matcher_demo.bag", 360, 681, 5.6), ("turtlebot3_scan2.bag", 538, 128, 3.0)],
)
def test_bags(name: str, scans: int, beams: int, limit: float) -> None:
    log = open_log(real(name))
    assert (len(log), len(log[0].ranges), log.odometry) == (scans, beams, None)
    assert log[0].range_max == pytest.approx(limit) and np.all(np.diff(log[0].bearings) > 0)
    assert log.notes == ("The log has no odometry: poses come from scan matching alone.",)
