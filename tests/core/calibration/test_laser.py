"""When beams are taken and how much too far they read is found again, and nothing is found where there is nothing."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.calibration.laser import LaserCalibration, oddness, sweep_share
from bspline_slam.logs.indexed_log import IndexedLog
from bspline_slam.scan import Records
from bspline_slam.slam import run_slam
from bspline_slam.snapshot import Snapshot
from core.rooms import loop_path, room_scan

BEAMS, PERIOD, SCANS = 271, 0.1, 160


@cache
def mapped(sweep: float, interlace: float, offset: float) -> tuple[np.ndarray, Snapshot]:
    """The map of a drive with turns to both sides, and its true poses."""
    rng = np.random.default_rng(1)
    number, time = np.arange(BEAMS), PERIOD * np.arange(SCANS)
    since = sweep * sweep_share(number, BEAMS) + interlace * oddness(number)
    poses = loop_path(SCANS)
    poses[:, 2] = np.unwrap(poses[:, 2]) + 0.6 * np.sin(2.0 * time)
    moved = np.stack([np.gradient(poses[:, axis], PERIOD) for axis in range(3)], -1)
    scans = []
    for k, (pose, rate) in enumerate(zip(poses, moved, strict=True)):
        scan = room_scan(pose + since[:, None] * rate, rng, index=k, noise=0.008, beams=BEAMS)
        scan.ranges[:] += offset
        scans.append(scan)
    records = Records(time, time, poses, np.arange(SCANS))
    log = IndexedLog.from_records(Path("room.log"), records, None, (), "", scans.__getitem__)
    return poses, run_slam(log).snapshot


@pytest.mark.parametrize("given", [(0.03, 0.0, 0.012), (-0.02, 0.015, 0.0)])
def test_what_a_laser_was_given_is_found_again(given: tuple[float, float, float]) -> None:
    found = mapped(*given)[1].laser
    assert found.sweep == pytest.approx(given[0], abs=3e-3)
    assert found.interlace == pytest.approx(given[1], abs=2e-3)
    assert found.offset == pytest.approx(given[2], abs=3e-3)


def test_nothing_is_found_where_there_is_nothing() -> None:
    found = mapped(0.0, 0.0, 0.0)[1].laser
    assert not found.tells
    assert np.isfinite(found.sweep_sigma)


def test_corrected_beams_make_poses_as_good_as_those_of_a_perfect_laser() -> None:
    def error(given: tuple[float, float, float]) -> float:
        poses, snapshot = mapped(*given)
        off = se2.between(se2.between(poses[0], poses), se2.between(snapshot.poses[0], snapshot.poses))
        return float(np.hypot(off[:, 0], off[:, 1]).mean())

    assert error((0.03, 0.0, 0.012)) < error((0.0, 0.0, 0.0)) + 0.002


def test_a_calibration_survives_being_written_down() -> None:
    told = LaserCalibration(0.01, 0.0, -0.008, 1e-3, np.inf, 5e-4)
    assert LaserCalibration.from_dict(json.loads(json.dumps(told.to_dict()))) == told
