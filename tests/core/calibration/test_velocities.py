"""Velocities are those of the drive, however its records were stamped."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.calibration.velocities import velocities
from bspline_slam.scan import Records


def circle(count: int, speed: float, turn: float, period: float) -> np.ndarray:
    heading = turn * period * np.arange(count)
    return np.stack([speed / turn * np.sin(heading), -speed / turn * np.cos(heading), heading], -1)


def records(times: np.ndarray, odometry: np.ndarray | None, every: int = 1) -> Records:
    scan = np.where(np.arange(len(times)) % every == 0, np.arange(len(times)) // every, -1)
    return Records(times, times, odometry, scan)


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("told", [False, True])
def test_a_steady_drive_has_the_same_velocity_throughout(every: int, told: bool) -> None:
    path = circle(300, 0.5, -0.4, 0.1)
    scans = path[::every]
    log = records(0.1 * np.arange(300), path if told else None, every)
    found = velocities(log, scans)[3:-3]
    np.testing.assert_allclose(found, np.tile([0.5, 0.0, -0.4], (len(found), 1)), atol=2e-3)


def test_bursts_of_records_do_not_show() -> None:
    path = circle(300, 0.5, 0.4, 0.1)
    stamps = 0.3 * (np.arange(300) // 3) + 1e-3 * np.arange(300)
    found = velocities(records(stamps, path), path)[20:-20]
    np.testing.assert_allclose(found, np.tile([0.5, 0.0, 0.4], (len(found), 1)), rtol=0.12, atol=0.01)


def test_a_single_scan_stands_still() -> None:
    np.testing.assert_array_equal(velocities(records(np.zeros(1), None), np.ones((1, 3))), np.zeros((1, 3)))


def test_a_jump_of_the_estimate_is_no_motion() -> None:
    path = circle(300, 0.5, 0.4, 0.1)
    path[150:, 0] += 3.0
    found = velocities(records(0.1 * np.arange(300), None), path)
    assert np.abs(found).max() < 0.6
