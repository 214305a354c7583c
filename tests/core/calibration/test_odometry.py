"""Bias and lag of odometry are found again in drives that were given them."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.calibration.odometry import in_step, odometry_bias, odometry_lag, steps
from bspline_slam.scan import Records


def drive(rng: np.random.Generator, count: int) -> np.ndarray:
    """A robot that turns now left, now right, never abruptly."""
    turn = 0.08 * np.sin(np.arange(count) * 0.3) + rng.normal(0.0, 0.01, count)
    poses = [np.zeros(3)]
    for angle in turn[1:]:
        poses.append(se2.compose(poses[-1], np.array([0.1, 0.0, angle])))
    return np.array(poses)


def records_with(odometry: np.ndarray | None, is_scan: np.ndarray) -> Records:
    stamps = np.arange(len(is_scan), dtype=float)
    return Records(stamps, stamps, odometry, np.where(is_scan, np.cumsum(is_scan) - 1, -1))


def biased(poses: np.ndarray, distance: float, turn: float, turn_per_metre: float) -> np.ndarray:
    """Odometry that has to be scaled so to give `poses`."""
    out = [poses[0]]
    for step in steps(poses):
        x = step[0] / distance
        out.append(se2.compose(out[-1], np.array([x, 0.0, (step[2] - turn_per_metre * x) / turn])))
    return np.array(out)


def test_bias_is_found_again() -> None:
    rng = np.random.default_rng(1)
    poses, is_scan = drive(rng, 600), np.ones(600, bool)
    found = odometry_bias(records_with(biased(poses, 0.96, 1.05, 0.03), is_scan), poses)
    assert found is not None
    np.testing.assert_allclose(
        (found.distance_scale, found.turn_scale, found.turn_per_metre, found.lever, found.lag),
        (0.96, 1.05, 0.03, 0.0, 0.0), atol=2e-3,
    )  # fmt: skip


def test_a_frame_ahead_of_the_wheels_shows_as_a_lever() -> None:
    wheels = drive(np.random.default_rng(2), 400)
    poses = se2.compose(wheels, np.array([0.2, 0.0, 0.0]))
    found = odometry_bias(records_with(wheels, np.ones(400, bool)), poses)
    assert found is not None
    assert found.lever == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize("lag", [-0.5, 0.0, 0.4])
def test_lag_is_found_again_and_taken_out(lag: float) -> None:
    rng = np.random.default_rng(3)
    truth = drive(rng, 800)
    is_scan = rng.random(800) < 0.6
    odometry = in_step(truth, -lag)
    records = records_with(odometry, is_scan)
    assert odometry_lag(records, truth[is_scan]) == pytest.approx(lag, abs=0.06)
    off = se2.between(truth, in_step(odometry, lag))[2:-2]
    assert np.abs(off[:, 2]).max() < 0.03


def test_a_drive_straight_on_tells_no_lag() -> None:
    poses = np.stack([np.arange(300) * 0.1, np.zeros(300), np.zeros(300)], -1)
    noisy = poses + np.random.default_rng(4).normal(0.0, 1e-3, poses.shape)
    assert odometry_lag(records_with(noisy, np.ones(300, bool)), poses) == 0.0


def test_no_odometry_has_no_bias() -> None:
    assert odometry_bias(records_with(None, np.ones(9, bool)), drive(np.random.default_rng(5), 9)) is None
