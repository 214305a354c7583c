"""Filtered odometry: nearer to the truth between scans, whatever is wrong with it, and untouched where it is right."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.calibration.odometry import in_step, steps
from bspline_slam.calibration.odometry_filter import filtered_odometry
from bspline_slam.scan import Records


def drive(rng: np.random.Generator, count: int) -> np.ndarray:
    """A robot that starts and stops, and turns now left, now right."""
    pace = 0.08 * (1.0 + np.sin(np.arange(count) * 0.17)) + rng.uniform(0.0, 0.02, count)
    turn = 0.08 * np.sin(np.arange(count) * 0.3) + rng.normal(0.0, 0.01, count)
    return chained(np.stack([pace, np.zeros(count), turn], -1))


def chained(moves: np.ndarray) -> np.ndarray:
    poses = [np.zeros(3)]
    for move in moves[1:]:
        poses.append(se2.compose(poses[-1], move))
    return np.array(poses)


def records_with(odometry: np.ndarray | None, is_scan: np.ndarray) -> Records:
    stamps = np.arange(len(is_scan), dtype=float)
    return Records(stamps, stamps, odometry, np.where(is_scan, np.cumsum(is_scan) - 1, -1))


def filtered(odometry: np.ndarray, is_scan: np.ndarray, poses: np.ndarray) -> np.ndarray:
    found = filtered_odometry(records_with(odometry, is_scan), poses)
    assert found is not None
    return found


def step_error(odometry: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """Mean error of the inner steps (m, rad)."""
    off = se2.between(steps(truth), steps(odometry))[2:-2]
    return float(np.hypot(off[:, 0], off[:, 1]).mean()), float(np.abs(off[:, 2]).mean())


def test_scale_and_bias_are_taken_out() -> None:
    truth = drive(np.random.default_rng(1), 600)
    is_scan = np.random.default_rng(2).random(600) < 0.5
    made = steps(truth)
    wrong = np.stack([1.06 * made[:, 0], made[:, 1], 0.9 * made[:, 2] - 0.05 * made[:, 0]], -1)
    odometry = chained(np.concatenate([np.zeros((1, 3)), wrong]))
    distance, turn = step_error(filtered(odometry, is_scan, truth[is_scan]), truth)
    assert distance < 2e-4 and turn < 2e-4


@pytest.mark.parametrize("lag", [-0.5, 0.4, 0.9])
def test_a_lag_is_taken_out(lag: float) -> None:
    truth = drive(np.random.default_rng(3), 800)
    is_scan = np.random.default_rng(4).random(800) < 0.6
    odometry = in_step(truth, -lag)
    raw, found = step_error(odometry, truth), step_error(filtered(odometry, is_scan, truth[is_scan]), truth)
    assert found[0] < 0.6 * raw[0] and found[1] < 0.6 * raw[1]


def test_a_frame_ahead_of_the_wheels_swings_about_them() -> None:
    wheels = drive(np.random.default_rng(5), 400)
    truth = se2.compose(wheels, np.array([0.2, 0.0, 0.0]))
    is_scan = np.random.default_rng(6).random(400) < 0.5
    distance, _ = step_error(filtered(wheels, is_scan, truth[is_scan]), truth)
    assert distance < 0.1 * step_error(wheels, truth)[0]


def test_odometry_of_the_wrong_sign_is_turned_round() -> None:
    truth = drive(np.random.default_rng(7), 500)
    is_scan = np.random.default_rng(8).random(500) < 0.5
    odometry = chained(np.concatenate([np.zeros((1, 3)), -steps(truth)]))
    distance, turn = step_error(filtered(odometry, is_scan, truth[is_scan]), truth)
    assert distance < 5e-3 and turn < 5e-3


def test_outliers_do_not_spoil_the_rest() -> None:
    truth = drive(np.random.default_rng(9), 500)
    poses = se2.compose(truth, np.zeros(3))
    poses[::50] = se2.compose(poses[::50], np.array([0.5, 0.5, 0.4]))
    distance, turn = step_error(filtered(truth, np.ones(500, bool), poses), truth)
    assert distance < 1e-3 and turn < 1e-3


def test_right_odometry_stays_as_it_is() -> None:
    truth = drive(np.random.default_rng(10), 200)
    moved = se2.compose(np.array([3.0, -1.0, 2.0]), truth)
    off = se2.between(steps(truth), steps(filtered(truth, np.ones(200, bool), moved)))
    assert np.abs(off).max() < 1e-7


def test_what_a_straight_drive_does_not_tell_stays_as_it_is() -> None:
    truth = np.stack([0.1 * np.arange(200.0), np.zeros(200), np.zeros(200)], -1)
    longer = truth * [1.05, 1.0, 1.0]
    longer[-1, 2] = 0.3
    found = filtered(longer, np.arange(200) < 199, truth[:199])
    assert step_error(found[:199], truth[:199])[0] < 1e-3
    assert found[-1, 2] == pytest.approx(0.3, abs=0.02)


def test_too_few_scans_or_frozen_wheels_tell_nothing() -> None:
    truth = drive(np.random.default_rng(11), 200)
    np.testing.assert_array_equal(filtered(1.1 * truth, np.arange(200) < 20, truth[:20]), 1.1 * truth)
    np.testing.assert_allclose(filtered(np.zeros((200, 3)), np.ones(200, bool), truth), 0.0, atol=1e-12)
    assert filtered_odometry(records_with(None, np.ones(200, bool)), truth) is None
