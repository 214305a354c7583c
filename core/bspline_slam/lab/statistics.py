"""Is an estimate as good as it says? Normalised errors, and the bands they stay in when its covariances are honest."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy import stats

WITHIN_2SIGMA = float(stats.chi2.cdf(4.0, 2))
"""Share of the plane's normal distribution inside its 2σ ellipse: 86.5 %."""
CONFIDENCE = 0.95

Band = tuple[float, float]


def nees(
    error: Float[np.ndarray, "d"],
    covariance: Float[np.ndarray, "d d"],
    least_variance: float = 0.0,
    held: Float[np.ndarray, "d d"] | None = None,
) -> tuple[float, float]:
    """Normalised estimation error squared eᵀ P⁻¹ e, and its degrees of freedom: the rank of P.

    Directions of P with a variance of at most `least_variance`, or none beyond rounding, are left out of both. `held`
    is what P claims beyond the errors that can occur: the mean is then that of P − held, tr(P⁻¹ held) less.
    """
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    rounding = len(values) * np.finfo(float).eps * max(float(values[-1]), 0.0)
    kept = values > max(least_variance, rounding)
    along = vectors[:, kept] / np.sqrt(values[kept])
    missing = 0.0 if held is None else float(np.trace(along.T @ held @ along))
    return float(np.sum((along.T @ error) ** 2)), float(kept.sum()) - missing


def chi_square_band(dof: float) -> Band:
    """Where χ²/dof lies with a probability of 95 %, as much left out below as above."""
    low, high = chi_square_bands(np.array([dof], dtype=float))[0]
    return float(low), float(high)


def chi_square_bands(dof: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n 2"]:
    """The band of each of many at once, which takes hardly longer than that of one."""
    return stats.chi2.ppf([0.5 * (1 - CONFIDENCE), 0.5 * (1 + CONFIDENCE)], dof[:, None]) / dof[:, None]


def binomial_band(trials: int, probability: float = WITHIN_2SIGMA) -> Band:
    """Where the share of successes in so many independent trials lies with a probability of at least 95 %."""
    low, high = stats.binom.ppf([0.5 * (1 - CONFIDENCE), 0.5 * (1 + CONFIDENCE)], trials, probability) / trials
    return float(low), float(high)
