"""How many bytes a map takes, and how many a grid of the same place would take."""

from __future__ import annotations

import gzip
from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from bspline_slam import se2
from bspline_slam.kernels import grid as kernels
from bspline_slam.lab.wall_beams import WallBeams
from bspline_slam.spline_map import SplineMap

CELL = 0.05
FREE, UNKNOWN, OCCUPIED = 254, 205, 0
"""Bytes of a cell, as in the grid maps of ROS."""


@dataclass(frozen=True, slots=True)
class MapSize:
    """Bytes of all control points and knots as 32-bit floats, and of a grid of 5 cm cells over the same rectangle, a
    byte each; both also packed by gzip, the grid where it is known what it holds."""

    splines: int
    control_points: int
    metres: float
    raw: int
    packed: int
    grid_raw: int
    grid_packed: int | None

    @classmethod
    def of(cls, splines: SplineMap, beams: WallBeams | None = None) -> MapSize:
        """That of a map; with beams also that of the grid that they would draw."""
        numbers = [np.concatenate([s.curve.control_points.ravel(), s.curve.knots]) for s in splines]
        data = np.concatenate([np.zeros(0), *numbers]).astype(np.float32).tobytes()
        drawn = None if beams is None else len(gzip.compress(occupancy(splines, beams).tobytes()))
        return cls(
            splines=len(splines),
            control_points=splines.control_point_count,
            metres=sum(spline.length for spline in splines),
            raw=len(data),
            packed=len(gzip.compress(data)),
            grid_raw=empty_grid(splines)[0].size,
            grid_packed=drawn,
        )


def occupancy(splines: SplineMap, beams: WallBeams) -> UInt8[np.ndarray, "rows columns"]:
    """What the beams show of the rectangle around the map: cells that they fly through and cells that they end in."""
    grid, corner = empty_grid(splines)
    sensors = beams.points - beams.ranges[:, None] * beams.directions
    origins = se2.transform(beams.poses[beams.pose], sensors)
    kernels.trace(grid, origins, beams.ends, corner, CELL, FREE, OCCUPIED)
    return grid


def empty_grid(splines: SplineMap) -> tuple[UInt8[np.ndarray, "rows columns"], np.ndarray]:
    """A grid of unknown cells over all supported curves, and its lower left corner (m)."""
    points = np.concatenate([np.zeros((0, 2)), *(spline.sample(CELL)[1] for spline in splines)])
    if len(points) == 0:
        return np.zeros((0, 0), np.uint8), np.zeros(2)
    corner = points.min(0)
    columns, rows = (int(n) for n in np.floor((points.max(0) - corner) / CELL) + 1)
    return np.full((rows, columns), UNKNOWN, np.uint8), corner
