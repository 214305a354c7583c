"""Acceptance bands against scipy.stats, and normalised errors of Gaussians that are what they claim to be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import Float
from scipy import stats

from bspline_slam.lab.statistics import WITHIN_2SIGMA, binomial_band, chi_square_band, nees


def covariance_of(rng: np.random.Generator, dimension: int, rank: int) -> Float[np.ndarray, "d d"]:
    root = rng.standard_normal((dimension, rank))
    return root @ root.T


@given(st.integers(1, 5000))
def test_the_chi_square_band_leaves_out_a_fortieth_on_each_side(dof: int) -> None:
    low, high = chi_square_band(dof)
    assert stats.chi2.cdf(low * dof, dof) == pytest.approx(0.025, abs=1e-9)
    assert stats.chi2.sf(high * dof, dof) == pytest.approx(0.025, abs=1e-9)


def test_the_bands_are_those_of_the_textbook() -> None:
    assert chi_square_band(3 * 50) == pytest.approx((0.787, 1.239), abs=1e-3)
    assert chi_square_band(3 * 100) == pytest.approx((0.846, 1.166), abs=1e-3)
    assert chi_square_band(26 * 50) == pytest.approx((0.925, 1.078), abs=1e-3)
    assert pytest.approx(0.8647, abs=1e-4) == WITHIN_2SIGMA


@given(st.integers(1, 2000))
def test_the_binomial_band_holds_at_least_what_it_promises(trials: int) -> None:
    low, high = binomial_band(trials)
    distribution = stats.binom(trials, WITHIN_2SIGMA)
    assert distribution.cdf(round(high * trials)) - distribution.cdf(round(low * trials) - 1) >= 0.95


@pytest.mark.parametrize(("dimension", "rank"), [(3, 3), (8, 8), (8, 5)])
def test_errors_of_an_honest_gaussian_stay_in_the_band_and_those_of_a_boastful_one_leave_it(
    dimension: int, rank: int
) -> None:
    rng = np.random.default_rng(5)
    covariance = covariance_of(rng, dimension, rank)
    errors = rng.multivariate_normal(np.zeros(dimension), covariance, 2000, method="eigh")
    values, dofs = zip(*(nees(error, covariance) for error in errors), strict=True)
    assert set(dofs) == {rank}
    low, high = chi_square_band(rank * len(errors))
    assert low < np.mean(values) / rank < high
    boastful = np.mean([nees(error, covariance / 1.2)[0] for error in errors]) / rank
    assert boastful > high


@given(st.integers(0, 2**32 - 1))
def test_nees_does_not_depend_on_the_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    covariance, error = covariance_of(rng, 4, 4) + 0.1 * np.eye(4), rng.standard_normal(4)
    turn, _ = np.linalg.qr(rng.standard_normal((4, 4)))
    value, dof = nees(error, covariance)
    assert nees(turn @ error, turn @ covariance @ turn.T) == (pytest.approx(value, rel=1e-6), dof)
    assert value == pytest.approx(error @ np.linalg.solve(covariance, error), rel=1e-6)


def test_directions_below_the_least_variance_are_left_out() -> None:
    error, covariance = np.array([1.0, 100.0]), np.diag([1.0, 1e-6])
    assert nees(error, covariance, least_variance=1e-4) == (pytest.approx(1.0), 1)


def test_what_a_covariance_claims_beyond_the_errors_that_can_occur_is_left_out() -> None:
    rng = np.random.default_rng(9)
    occurring = covariance_of(rng, 6, 6)
    held = covariance_of(rng, 6, 3)
    errors = rng.multivariate_normal(np.zeros(6), occurring, 3000)
    values, dofs = zip(*(nees(error, occurring + held, held=held) for error in errors), strict=True)
    assert 0.0 < dofs[0] < 6.0
    assert np.mean(values) / dofs[0] == pytest.approx(1.0, abs=0.1)
