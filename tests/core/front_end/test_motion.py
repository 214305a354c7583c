"""Odometry calibration learns a bias and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.motion import MotionConfig, OdometryCalibration, Unexplained, guesses, step_information

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


def test_without_odometry_a_robot_is_taken_to_go_on_as_far_as_usual_and_to_stop_turning() -> None:
    late = [np.array([0.5, 0.0, 0.0])] * 4 + [np.array([0.0, 0.0, 0.6])] * 2 + [np.array([0.4, 0.02, -0.2])]
    config = MotionConfig()
    tries = guesses(None, late, config, believed=False)
    np.testing.assert_allclose(tries[0], [0.5, 0.0, -0.2 * config.momentum])
    assert any(np.array_equal(step, late[-1]) for step in tries)
    np.testing.assert_array_equal(tries[-1], se2.IDENTITY)


def test_nothing_is_known_of_the_first_step() -> None:
    np.testing.assert_array_equal(np.array(guesses(None, [], MotionConfig(), believed=False)), 0.0)


def test_odometry_comes_last_where_it_is_not_believed() -> None:
    wheels, late = np.array([0.3, 0.0, 0.0]), [np.array([0.2, 0.0, 0.1])]
    first, second = (
        guesses((1.1 * wheels, wheels), late, MotionConfig(), believed=believed) for believed in (True, False)
    )
    np.testing.assert_array_equal(first[0], 1.1 * wheels)
    np.testing.assert_array_equal(second[-1], wheels)
    assert not any(np.array_equal(step, wheels) for step in second[:3])


CLEAR = np.diag([1e5, 1e5, 1e5])


def judged(
    rng: np.random.Generator, wrong: np.ndarray, steps: int, seen: np.ndarray = CLEAR, turns: float = 0.1
) -> Unexplained:
    """The verdict on odometry that says `wrong` @ step, with noise, of each step made."""
    found, config = Unexplained.at_start(MotionConfig()), MotionConfig()
    for _ in range(steps):
        made = np.array([0.15, 0.0, rng.normal(0, turns)])
        found = found.learned(wrong @ made + rng.normal(0, 0.01, 3), made, seen, config)
    return found


@pytest.mark.parametrize("signs", [(-1, 1, 1), (1, 1, -1), (0, 0, 0), (-1, -1, -1)])
def test_reversed_and_frozen_odometry_is_found_out_within_a_metre(signs: tuple[int, int, int]) -> None:
    assert not judged(np.random.default_rng(3), np.diag(signs), 7).fits


def test_odometry_with_a_common_bias_fits() -> None:
    assert judged(np.random.default_rng(4), BIAS, 200).fits
    assert judged(np.random.default_rng(5), np.diag([1.3, 1.0, 1.3]), 200).fits


def test_along_a_bare_corridor_nothing_is_held_against_odometry() -> None:
    corridor = np.diag([0.0, 1e5, 1e5])
    assert judged(np.random.default_rng(6), np.diag([-1.0, 1.0, 1.0]), 50, corridor, turns=0.0).fits


def test_a_straight_drive_is_no_evidence_against_noisy_headings() -> None:
    rng, config = np.random.default_rng(9), MotionConfig()
    found = Unexplained.at_start(config)
    for _ in range(200):
        found = found.learned(np.array([0.6, 0.0, rng.normal(0, 0.06)]), np.array([0.6, 0.0, 0.0]), CLEAR, config)
        assert found.fits


def test_what_fits_again_is_believed_again() -> None:
    rng, config = np.random.default_rng(7), MotionConfig()
    found = judged(rng, np.zeros((3, 3)), 20)
    for _ in range(60):
        made = np.array([0.15, 0.0, rng.normal(0, 0.1)])
        found = found.learned(made + rng.normal(0, 0.01, 3), made, CLEAR, config)
    assert found.fits


def test_a_bias_is_learnt_sooner_where_odometry_was_found_not_to_fit() -> None:
    flipped, config = np.diag([-1.0, 1.0, 1.0]), MotionConfig()
    learned = learnt(np.random.default_rng(8), flipped, 15)
    distrusted = replace(learned, distrusted=True)
    assert distrusted.matrix(config)[0, 0] < -0.9 < learned.matrix(config)[0, 0]
