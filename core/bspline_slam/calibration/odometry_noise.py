"""How far odometry really errs, learnt from the steps between key scans that beams tell well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.front_end.motion import MotionConfig, step_errors
from bspline_slam.graph import PoseFactor

LEAST_STEPS = 50
"""Fewer steps than these say nothing about noise."""
TOLD = 0.3
"""Beams tell a step well along an axis that they know by this share of the error configured for odometry."""
CAREFUL = 1.5
"""Errors of neighbouring steps go together, which single steps do not show."""
LEAST_SHARE = 0.25
"""Share of the error configured below which odometry is never believed to err."""
USUAL, SLIP = 1.96, 3.0
"""Standard deviations within which 95 % of errors lie, and beyond which wheels slipped."""


def with_learnt_noise(
    factors: Sequence[PoseFactor], poses: Float[np.ndarray, "n 3"], config: MotionConfig
) -> list[PoseFactor]:
    """Pose factors with the noise of odometry as these poses tell it; steps that it tells wrong as noisy as that."""
    wheels = [k for k, factor in enumerate(factors) if _of_wheels(factor, config)]
    if not wheels:
        return list(factors)
    chosen = [factors[k] for k in wheels]
    errors = np.array([step_errors(factor.measured, config) for factor in chosen])[:, [0, 0, 1]]
    pairs = np.array([(factor.i, factor.j) for factor in chosen])
    measured = np.array([factor.measured for factor in chosen])
    off = se2.between(measured, se2.between(poses[pairs[:, 0]], poses[pairs[:, 1]])) / errors
    told = _uncertainties(factors, pairs) < TOLD * errors
    share = np.array([noise_share(off[told[:, axis], axis]) for axis in range(3)])
    slip = np.sqrt(np.square(off / share).sum(1)) / SLIP
    sigma = errors * share * np.maximum(slip, 1.0)[:, None]
    out = list(factors)
    for k, one in zip(wheels, sigma, strict=True):
        out[k] = replace(out[k], sqrt_information=np.diag(1.0 / one))
    return out


def noise_share(off: Float[np.ndarray, "k"]) -> float:
    """Standard deviation of errors that were expected to have 1: by the median, or by the largest of 95 % where tails
    are heavier than those of a Gaussian; 1 where too few tell it, and never more."""
    if len(off) < LEAST_STEPS:
        return 1.0
    middle, tail = np.percentile(np.abs(off), [50.0, 95.0])
    return float(np.clip(CAREFUL * max(1.4826 * middle, tail / USUAL), LEAST_SHARE, 1.0))


def _of_wheels(factor: PoseFactor, config: MotionConfig) -> bool:
    """Whether odometry said it, and not only that there was a step."""
    along, turn = step_errors(factor.measured, config)
    expected = np.diag([1.0 / along, 1.0 / along, 1.0 / turn])
    return factor.kind == "odometry" and np.allclose(np.abs(factor.sqrt_information).sum(0), expected.sum(0))


def _uncertainties(factors: Sequence[PoseFactor], pairs: Int[np.ndarray, "k 2"]) -> Float[np.ndarray, "k 3"]:
    """Standard deviations (m, m, rad) that scan matching alone leaves to the steps of these pairs."""
    matched = {(factor.i, factor.j): factor.sqrt_information for factor in factors if factor.kind == "matching"}
    roots = np.array([matched.get((i, j), np.zeros((3, 3))) for i, j in pairs.tolist()])
    known = roots.swapaxes(1, 2) @ roots + 1e-6 * np.eye(3)
    return np.sqrt(np.diagonal(np.linalg.inv(known), axis1=1, axis2=2))
