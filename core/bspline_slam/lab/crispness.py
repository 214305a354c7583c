"""How crisp a map is: how near the ends of beams lie to the curves that they saw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.curve_samples import CurveSamples
from bspline_slam.lab.wall_beams import WallBeams
from bspline_slam.spline_map import SplineMap

SPACING = 0.01
"""Distance (m) between the samples of a curve; between them its tangent stands for it."""
REACH = 0.15
"""A beam that ends farther than this (m) from every curve saw none of them."""
FACING = 0.05
"""Least cosine between the normal of a curve and the way back to the sensor: walls are seen from their own side."""
CRISP, CLOSE = 0.05, 0.03
"""Largest distances (m) of the beams that count in the root mean square, and of those that lie on a curve."""


@dataclass(frozen=True, slots=True)
class Crispness:
    """Of `beams` beam ends on walls: root mean square distance (m) of those within 5 cm of a curve, the shares of all
    within 5 cm and within 3 cm."""

    beams: int
    rms: float
    within_5cm: float
    within_3cm: float

    @classmethod
    def of(cls, distances: Float[np.ndarray, "m"]) -> Crispness:
        """From distances to the nearest curves (m; inf where there is none); NaN where nothing is near."""
        crisp = distances[distances < CRISP]
        rms = float(np.sqrt(np.mean(crisp**2))) if len(crisp) else float("nan")
        shares = [float(np.mean(distances < limit)) if len(distances) else float("nan") for limit in (CRISP, CLOSE)]
        return cls(len(distances), rms, *shares)


def nearest_curves(beams: WallBeams, splines: SplineMap) -> tuple[Float[np.ndarray, "m"], Int[np.ndarray, "m"]]:
    """For each beam the distance (m) from its end to the nearest curve that faces its sensor, and that curve's place in
    the map; inf and −1 where none is within REACH."""
    if len(splines) == 0 or len(beams) == 0:
        return np.full(len(beams), np.inf), np.full(len(beams), -1)
    samples = CurveSamples.of(splines.splines, SPACING)
    found = samples.facing(beams.ends, beams.towards, REACH, FACING, 1)[:, 0]
    across, along = np.abs(samples.apart(beams.ends, found))
    distance = np.hypot(across, np.where(along > SPACING, along, 0.0))
    return np.where(found >= 0, distance, np.inf), np.where(found >= 0, samples.owner[found], -1)


def crispness(beams: WallBeams, splines: SplineMap) -> Crispness:
    """That of a map under these beams."""
    return Crispness.of(nearest_curves(beams, splines)[0])
