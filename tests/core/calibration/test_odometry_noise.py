"""The noise of odometry is learnt where beams tell the steps, and slips do not make it look worse."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.calibration.odometry_noise import CAREFUL, LEAST_SHARE, noise_share, with_learnt_noise
from bspline_slam.front_end.motion import MotionConfig, step_errors
from bspline_slam.graph import PoseFactor

CONFIG = MotionConfig()
STEPS = 400
SURE = np.diag([1e3, 1e3, 1e3])


def drive(rng: np.random.Generator, share: float, known: np.ndarray = SURE) -> tuple[list[PoseFactor], np.ndarray]:
    """Poses with odometry that errs by a share of what is configured, and matches that know the steps so well."""
    poses, factors = [np.zeros(3)], []
    for k in range(STEPS):
        step = np.array([0.5, 0.0, rng.normal(0.0, 0.2)])
        poses.append(se2.compose(poses[-1], step))
        along, turn = step_errors(step, CONFIG)
        told = se2.compose(step, share * np.array([along, along, turn]) * rng.standard_normal(3))
        along, turn = step_errors(told, CONFIG)
        factors.append(PoseFactor(k, k + 1, told, np.diag([1 / along, 1 / along, 1 / turn]), "odometry"))
        factors.append(PoseFactor(k, k + 1, step, known, "matching"))
    return factors, np.array(poses)


def shares(before: list[PoseFactor], after: list[PoseFactor]) -> np.ndarray:
    """By how much the standard deviations of odometry have become smaller."""
    pairs = zip(before, after, strict=True)
    kept = [np.diag(a.sqrt_information) / np.diag(b.sqrt_information) for a, b in pairs if a.kind == "odometry"]
    return np.array(kept)


@pytest.mark.parametrize("share", [0.2, 0.35, 0.5])
def test_the_noise_that_odometry_has_is_found_with_some_care(share: float) -> None:
    factors, poses = drive(np.random.default_rng(1), share)
    found = np.median(shares(factors, with_learnt_noise(factors, poses, CONFIG)), axis=0)
    np.testing.assert_allclose(found, CAREFUL * share, rtol=0.15)


def test_slips_stay_as_uncertain_as_they_are_wrong() -> None:
    rng = np.random.default_rng(2)
    factors, poses = drive(rng, 0.2)
    slipped = poses.copy()
    ahead = se2.compose(poses[200], np.array([0.6, 0.0, 0.0]))
    slipped[200:] = se2.compose(ahead, se2.between(poses[200], poses[200:]))
    slipped[200] = poses[200]
    found = shares(factors, with_learnt_noise(factors, slipped, CONFIG))
    assert np.median(found[:, 0]) < 0.4
    assert found[200, 0] > 1.0


def test_odometry_is_never_taken_for_worse_than_configured_nor_for_perfect() -> None:
    for share, expected in ((3.0, 1.0), (0.001, LEAST_SHARE)):
        factors, poses = drive(np.random.default_rng(3), share)
        off = shares(factors, with_learnt_noise(factors, poses, CONFIG))
        assert off.min() == pytest.approx(expected)


def test_steps_along_a_corridor_teach_nothing() -> None:
    corridor = np.diag([0.1, 1e3, 1e3])
    factors, poses = drive(np.random.default_rng(4), 0.3, corridor)
    found = np.median(shares(factors, with_learnt_noise(factors, poses, CONFIG)), axis=0)
    assert found[0] == pytest.approx(1.0)
    assert (found[1:] < 0.6).all()


def test_other_factors_and_short_logs_are_left_alone() -> None:
    factors, poses = drive(np.random.default_rng(5), 0.3)
    loose = PoseFactor(0, 1, np.zeros(3), np.diag([1.0, 1.0, 2.0]), "odometry")
    after = with_learnt_noise([loose, *factors], poses, CONFIG)
    assert after[0] is loose
    assert [a is b for a, b in zip(factors, after[1:], strict=True)] == [f.kind != "odometry" for f in factors]
    np.testing.assert_array_equal(noise_share(np.ones(10)), 1.0)
    assert with_learnt_noise([], np.zeros((1, 3)), CONFIG) == []
