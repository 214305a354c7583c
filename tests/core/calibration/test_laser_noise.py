"""The noise of range and bearing is found again in residuals that have it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import nnls

from bspline_slam.calibration.laser_noise import laser_noise, not_negative


def residuals(rng: np.random.Generator, count: int, noise: tuple[float, float]) -> tuple[np.ndarray, ...]:
    angle = rng.uniform(-1.3, 1.3, count)
    along, aside = np.cos(angle), rng.uniform(0.5, 12.0, count) * np.sin(angle)
    return rng.normal(0.0, np.hypot(noise[0] * along, noise[1] * aside)), along, aside


@pytest.mark.parametrize("noise", [(0.01, 0.001), (0.03, 0.004), (0.005, 0.006)])
def test_both_parts_of_the_noise_are_found(noise: tuple[float, float]) -> None:
    across, along, aside = residuals(np.random.default_rng(1), 20000, noise)
    assert laser_noise(across, along, aside, (0.012, 0.003)) == pytest.approx(noise, rel=0.06)


def test_clutter_does_not_count() -> None:
    rng = np.random.default_rng(2)
    across, along, aside = residuals(rng, 20000, (0.01, 0.002))
    across[:1000] += rng.choice([-1.0, 1.0], 1000) * 0.3
    assert laser_noise(across, along, aside, (0.012, 0.003)) == pytest.approx((0.01, 0.002), rel=0.06)


def test_unknowns_take_their_share() -> None:
    across, along, aside = residuals(np.random.default_rng(3), 4000, (0.01, 0.002))
    bare, corrected = (laser_noise(across, along, aside, (0.012, 0.003), unknowns) for unknowns in (0, 1000))
    np.testing.assert_allclose(np.divide(corrected, bare), np.sqrt(1 / 0.75), rtol=0.03)


def test_a_few_beams_say_nothing() -> None:
    across, along, aside = residuals(np.random.default_rng(4), 100, (0.05, 0.01))
    assert laser_noise(across, along, aside, (0.012, 0.003)) == (0.012, 0.003)


NUMBERS = st.floats(-2, 2).map(lambda number: round(number, 3))
"""None so small that its square is nothing."""


@given(arrays(float, (3, 2), elements=NUMBERS), arrays(float, 3, elements=NUMBERS))
def test_least_squares_without_negative_parts(rows: np.ndarray, right: np.ndarray) -> None:
    def cost(x: np.ndarray) -> float:
        return float(np.sum((rows @ x - right) ** 2))

    found = not_negative(rows.T @ rows, rows.T @ right)
    best, _ = nnls(rows, right)
    assert (found >= 0.0).all()
    assert cost(found) <= cost(best) + 1e-6
