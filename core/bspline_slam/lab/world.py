"""A world to simulate in: lines, arcs and B-splines in the plane, the laser that sees them, the drive through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.bspline import BSpline
from bspline_slam.lab.drive import Drive

ON_THE_END = 1e-12
"""Slack of a line's parameter, so that no ray slips through the joint of two lines."""
NEAREST = 1e-9
"""Hits closer than this (m) are the origin itself."""


@dataclass(frozen=True, eq=False, slots=True)
class Laser:
    """A planar laser: angles in rad, distances in m, `pose_robot_sensor` where it sits on the robot.

    Beams start at −field_of_view/2 and the last one stays one resolution short of +field_of_view/2, as 180 beams of 1°
    cover −90…+89°.
    """

    field_of_view: float
    resolution: float
    range_min: float
    range_max: float
    pose_robot_sensor: Float[np.ndarray, "3"]

    @property
    def bearings(self) -> Float[np.ndarray, "beams"]:
        count = round(self.field_of_view / self.resolution)
        return -self.field_of_view / 2 + self.resolution * np.arange(count)


@dataclass(frozen=True, eq=False, slots=True)
class World:
    """Everything a simulated scan depends on but its noise.

    `lines` are end points (start, end); `arcs` are rows (centre x, centre y, radius, start angle, sweep) with the sweep
    positive counter-clockwise; metres and radians in the world frame.
    """

    name: str
    lines: Float[np.ndarray, "l 2 2"]
    arcs: Float[np.ndarray, "a 5"]
    splines: tuple[BSpline, ...]
    laser: Laser
    drive: Drive

    def cast(self, origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
        """Exact distance to the first thing along each ray; +inf where there is none. Directions are unit vectors."""
        return self.hits(origin, directions)[0]

    def hits(
        self, origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
    ) -> tuple[Float[np.ndarray, "m"], Int[np.ndarray, "m"]]:
        """The distances of `cast`, and the shape that each ray meets: lines are counted first, then arcs, then
        splines; −1 for none."""
        lines, arcs = _line_table(self.lines, origin, directions), _arc_table(self.arcs, origin, directions)
        table = np.concatenate([lines, arcs, np.full((len(directions), 1), np.inf)], axis=1)
        shape = table.argmin(axis=1)
        reach = np.take_along_axis(table, shape[:, None], axis=1)[:, 0]
        for number, spline in enumerate(self.splines, len(self.lines) + len(self.arcs)):
            seen = np.flatnonzero(box_ranges(spline.control_points, origin, directions) < reach)
            if len(seen):
                met, _ = spline.ray_hits(origin, directions[seen])
                nearer = seen[met < reach[seen]]
                reach[seen], shape[nearer] = np.fmin(reach[seen], met), number
        return reach, np.where(np.isfinite(reach), shape, -1)


def line_ranges(
    lines: Float[np.ndarray, "l 2 2"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m"]:
    """Distance along each ray u to the nearest line; +inf where there is none."""
    return _line_table(lines, origin, directions).min(axis=1, initial=np.inf)


def _line_table(
    lines: Float[np.ndarray, "l 2 2"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m l"]:
    """Distance along each ray u to each line a + s·d, 0 ≤ s ≤ 1: solves o + t·u = a + s·d by cross products."""
    off, along = lines[:, 0] - origin, lines[:, 1] - lines[:, 0]
    turn = directions @ _crossed(along).T
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (off * _crossed(along)).sum(1) / turn
        s = directions @ _crossed(-off).T / turn
    hit = (turn != 0) & (t > NEAREST) & (s >= -ON_THE_END) & (s <= 1 + ON_THE_END)
    return np.where(hit, t, np.inf)


def arc_ranges(
    arcs: Float[np.ndarray, "a 5"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m"]:
    """Distance along each ray to the nearest arc; +inf where there is none."""
    return _arc_table(arcs, origin, directions).min(axis=1, initial=np.inf)


def _arc_table(
    arcs: Float[np.ndarray, "a 5"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m a"]:
    """Distance along each ray to each arc: the roots of |o + t·u − c|² = r² whose angle lies in the sweep."""
    off, radius = origin - arcs[:, :2], arcs[:, 2]
    half = directions @ off.T
    under_root = half**2 - (off**2).sum(1) + radius**2
    ray, arc = np.nonzero(under_root >= 0)
    middle, root = -half[ray, arc], np.sqrt(under_root[ray, arc])
    reach = np.full(half.shape, np.inf)
    for t in (middle + root, middle - root):
        end = off[arc] + t[:, None] * directions[ray]
        hit = (t > NEAREST) & _in_sweep(np.arctan2(end[:, 1], end[:, 0]), arcs[arc])
        reach[ray[hit], arc[hit]] = t[hit]
    return reach


def _in_sweep(angle: Float[np.ndarray, "n"], arcs: Float[np.ndarray, "n 5"]) -> Bool[np.ndarray, "n"]:
    """Whether the arc of each row covers the angle, with the same slack at both of its ends."""
    start, sweep = arcs[:, 3], arcs[:, 4]
    turned = np.sign(sweep) * (angle - start) % (2 * np.pi)
    return (turned <= np.abs(sweep) + NEAREST) | (turned >= 2 * np.pi - NEAREST)


def box_ranges(
    points: Float[np.ndarray, "n 2"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m"]:
    """Distance at which each ray enters the bounding box of points (0 from inside, +inf past it): a lower bound."""
    with np.errstate(divide="ignore"):
        inverse = 1.0 / directions
    with np.errstate(invalid="ignore"):
        a, b = (points.min(0) - NEAREST - origin) * inverse, (points.max(0) + NEAREST - origin) * inverse
    enter, leave = np.fmin(a, b).max(axis=1), np.fmax(a, b).min(axis=1)
    return np.where(leave >= np.maximum(enter, 0.0), np.maximum(enter, 0.0), np.inf)


def _crossed(vectors: Float[np.ndarray, "l 2"]) -> Float[np.ndarray, "l 2"]:
    """The vectors turned so that u · _crossed(v) is the cross product u × v."""
    return np.stack([vectors[:, 1], -vectors[:, 0]], -1)
