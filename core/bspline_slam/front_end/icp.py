"""The one adapter around kiss-icp: point-to-point ICP of planar beam ends, lifted to z = 0 and back.

It calls the compiled part of the package directly: the classes around it load a reader of configuration files first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from kiss_icp.pybind import kiss_icp_pybind as kiss_icp


@dataclass(frozen=True, slots=True)
class IcpConfig:
    """Voxel of the map, largest correspondence, scale of the robust kernel (m), and when to stop."""

    voxel: float = 0.2
    points_per_voxel: int = 20
    reach: float = 0.2
    kernel: float = 0.05
    iterations: int = 20
    convergence: float = 1e-3


DECIMALS = 9
"""Places of the result that are kept: kiss-icp adds up in an order that hangs on the number of cores."""


def icp_map(points: Float[np.ndarray, "m 2"], config: IcpConfig) -> Any:
    """World points as kiss-icp's voxel map."""
    voxels = kiss_icp._VoxelHashMap(config.voxel, 1e6, config.points_per_voxel)
    voxels._add_points(_lifted(points))
    return voxels


def align(
    voxels: Any, points: Float[np.ndarray, "m 2"], guess: Float[np.ndarray, "3"], config: IcpConfig
) -> Float[np.ndarray, "3"]:
    """The pose that puts `points` (robot frame) on the map, from `guess` (KISS-ICP, Vizzo et al. 2023, eqs 7–9).

    A result that left the plane or is not finite (too few beams, all on one line) gives the guess back.
    """
    c, s = np.cos(guess[2]), np.sin(guess[2])
    start = np.eye(4)
    start[:2, :2] = [[c, -s], [s, c]]
    start[:2, 3] = guess[:2]
    registration = kiss_icp._Registration(config.iterations, config.convergence, 1)
    found = registration._align_points_to_map(_lifted(points), voxels, start, config.reach, config.kernel)
    flat = abs(found[2, 2] - 1.0) < 1e-3 and abs(found[2, 3]) < 1e-3
    if not np.isfinite(found).all() or not flat:
        return guess
    return np.round([found[0, 3], found[1, 3], np.arctan2(found[1, 0], found[0, 0])], DECIMALS)


def _lifted(points: Float[np.ndarray, "m 2"]) -> Any:
    """The points with z = 0, as a list of vectors of kiss-icp."""
    return kiss_icp._Vector3dVector(np.column_stack([points, np.zeros(len(points))]))
