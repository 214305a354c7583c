"""Odometry calibration learns a bias and nothing else."""

from __future__ import annotations

import numpy as np

from bspline_slam import se2
from bspline_slam.motion import MotionConfig, OdometryCalibration, guesses, step_information

BIAS = np.array([[0.96, 0.0, 0.0], [0.0, 1.0, 0.08], [0.055, 0.0, 0.97]])


def learnt(rng: np.random.Generator, bias: np.ndarray, steps: int) -> OdometryCalibration:
    calibration, config = OdometryCalibration(), MotionConfig()
    for _ in range(steps):
        step = np.array([rng.uniform(0, 0.5), 0.0, rng.normal(0, 0.2)])
        matched = bias @ step + rng.normal(0, 0.005, 3)
        calibration = calibration.learned(step, matched, config)
    return calibration


def test_a_constant_bias_is_learnt() -> None:
    found = learnt(np.random.default_rng(0), BIAS, 400).matrix(MotionConfig())
    np.testing.assert_allclose(found[:, [0, 2]], BIAS[:, [0, 2]], atol=0.02)


def test_a_wrong_sign_is_learnt() -> None:
    found = learnt(np.random.default_rng(1), np.diag([-1.0, 1.0, 1.0]), 400).matrix(MotionConfig())
    assert found[0, 0] < -0.9


def test_nothing_is_corrected_before_there_is_something_to_learn_from() -> None:
    np.testing.assert_array_equal(learnt(np.random.default_rng(2), BIAS, 3).matrix(MotionConfig()), np.eye(3))


def test_longer_and_sharper_steps_are_less_certain() -> None:
    config = MotionConfig()
    short = np.diag(step_information(np.array([0.1, 0.0, 0.1]), config))
    assert (short > np.diag(step_information(np.array([1.0, 0.0, 0.1]), config))).all()
    assert (short > np.diag(step_information(np.array([0.1, 0.0, 1.0]), config))).all()


def test_without_odometry_constant_velocity_is_tried_first() -> None:
    last = np.array([0.2, 0.0, 0.1])
    tries = guesses(None, last, OdometryCalibration(), MotionConfig())
    np.testing.assert_array_equal(tries[0], last)
    np.testing.assert_array_equal(tries[-1], se2.IDENTITY)
