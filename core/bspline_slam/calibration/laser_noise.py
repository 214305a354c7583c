"""The noise of the laser, from what the beams leave over of the map."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.models.protocol import Model
from bspline_slam.observation import incidence
from bspline_slam.sights import Feet, Sights
from bspline_slam.spline_map import SplineMap

LEAST_BEAMS = 500
"""Fewer beams than these say nothing about noise."""
REACH = 3.0
"""Beams farther off than so many standard deviations tell of clutter, not of noise; of a Gaussian's variance the rest
holds `WITHIN_REACH`."""
WITHIN_REACH = 0.9733
LEAST_RANGE_NOISE, LEAST_BEARING_NOISE = 1e-3, 1e-4


def laser_noise(
    across: Float[np.ndarray, "m"],
    along: Float[np.ndarray, "m"],
    aside: Float[np.ndarray, "m"],
    start: tuple[float, float],
    unknowns: int = 0,
    rounds: int = 8,
) -> tuple[float, float]:
    """Standard deviation of range (m) and bearing (rad) that explain the distances `across` the curves (m).

    A beam that meets its curve at n·u = `along`, ρ·(n × u) = `aside` (m) errs across it by σ² = σ_ρ² along² + σ_φ²
    aside². Least squares on the squared distances of the beams within reach, from `start`, which is returned where
    there are too few of them. `unknowns` is how many were fitted to the beams, and took their share of the noise.
    """
    if len(across) < LEAST_BEAMS + 2 * unknowns:
        return start
    left = WITHIN_REACH * (1.0 - unknowns / len(across))
    variance = np.square(start)
    for _ in range(rounds):
        expected = variance[0] * along**2 + variance[1] * aside**2
        near = across**2 < REACH**2 * expected
        if np.count_nonzero(near) < LEAST_BEAMS:
            return start
        weight = 1.0 / expected[near]
        rows = np.stack([along[near] ** 2, aside[near] ** 2], -1) * weight[:, None]
        seen = across[near] ** 2 / left * weight
        scale = np.sqrt(np.square(rows).sum(0))
        found = not_negative((rows / scale).T @ (rows / scale), (rows / scale).T @ seen)
        variance = np.maximum(found / scale, (LEAST_RANGE_NOISE**2, LEAST_BEARING_NOISE**2))
    return float(np.sqrt(variance[0])), float(np.sqrt(variance[1]))


def not_negative(A: Float[np.ndarray, "2 2"], b: Float[np.ndarray, "2"]) -> Float[np.ndarray, "2"]:
    """The x ≥ 0 with the least xᵀAx/2 − bᵀx, A positive semidefinite: inside where both are positive, else on that axis
    where it is least."""
    inside = np.linalg.lstsq(A, b)[0]
    if (inside >= 0.0).all():
        return inside
    alone = np.maximum(b, 0.0) / np.maximum(np.diag(A), 1e-300)
    better = int(alone[1] * b[1] > alone[0] * b[0])
    return np.where(np.arange(2) == better, alone, 0.0)


def calibrated(model: Model, splines: SplineMap, sights: Sights, feet: Feet, poses: Float[np.ndarray, "n 3"]) -> Model:
    """The model with the noise of the laser as these feet tell it; beams measure one of the two coordinates of a
    control point."""
    kept = np.flatnonzero(feet.counts)
    normals = se2.rotate(-poses[sights.pose[kept]], feet.normals[kept])
    along, beside = incidence(normals, sights.directions[kept])
    fitting = model.fitting
    unknowns = 3 * len(poses) + splines.control_point_count
    range_noise, bearing_noise = laser_noise(
        feet.across[kept], along, sights.ranges[kept] * beside,
        (fitting.range_noise, fitting.bearing_noise), unknowns,
    )  # fmt: skip
    return model.with_noise(range_noise, bearing_noise)
