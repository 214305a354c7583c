"""Steps of the drive that nothing measured in every direction: along a bare corridor, say, where no odometry is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.graph import PoseFactor

OPEN = 0.3
"""A step is open where it is not told to so many metres (1 σ) in some direction."""


def open_steps(factors: Sequence[PoseFactor], key_scans: Int[np.ndarray, "n"]) -> tuple[int, ...]:
    """The key scans (by index of the log) whose step from the one before is open, by what beams and wheels tell."""
    told = np.zeros((len(key_scans), 3, 3))
    for factor in factors:
        if factor.kind != "loop" and factor.j == factor.i + 1:
            told[factor.j] += factor.sqrt_information.T @ factor.sqrt_information
    return tuple(int(scan) for scan in key_scans[1:][_widest(told[1:]) > OPEN])


def _widest(information: Float[np.ndarray, "n 3 3"]) -> Float[np.ndarray, "n"]:
    """Largest standard deviation of a position (m) that informations of poses leave."""
    covariance = np.linalg.inv(information + 1e-6 * np.eye(3))
    return np.sqrt(np.linalg.eigvalsh(covariance[:, :2, :2])[:, -1])
