"""A world to simulate in: lines, arcs and B-splines in the plane, the laser that sees them, the drive through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

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
        reach = np.minimum(line_ranges(self.lines, origin, directions), arc_ranges(self.arcs, origin, directions))
        for spline in self.splines:
            seen = box_ranges(spline.control_points, origin, directions) < reach
            if seen.any():
                hits, _ = spline.ray_hits(origin, directions[seen])
                reach[seen] = np.fmin(reach[seen], hits)
        return reach

    def outlines(self, spacing: float = 0.05) -> list[Float[np.ndarray, "s 2"]]:
        """Every line, arc and spline as a polyline with points at most about `spacing` apart along curves."""
        arcs = [arc_points(arc, spacing) for arc in self.arcs]
        return [*self.lines, *arcs, *(spline.sample(spacing)[1] for spline in self.splines)]


def arc_points(arc: Float[np.ndarray, "5"], spacing: float) -> Float[np.ndarray, "s 2"]:
    """Points of one arc, at most about `spacing` metres apart."""
    x, y, radius, start, sweep = arc
    count = max(int(np.ceil(abs(sweep) * radius / spacing)), 1) + 1
    angle = start + np.linspace(0.0, sweep, count)
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], -1)


def line_ranges(
    lines: Float[np.ndarray, "l 2 2"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m"]:
    """Distance along each ray u to the nearest line a + s·d, 0 ≤ s ≤ 1: solves o + t·u = a + s·d by cross products."""
    if len(lines) == 0:
        return np.full(len(directions), np.inf)
    off, along = lines[:, 0] - origin, lines[:, 1] - lines[:, 0]
    turn = _cross(directions[:, None], along)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = _cross(off, along) / turn
        s = _cross(off, directions[:, None]) / turn
    hit = (turn != 0) & (t > NEAREST) & (s >= -ON_THE_END) & (s <= 1 + ON_THE_END)
    return np.where(hit, t, np.inf).min(axis=1)


def arc_ranges(
    arcs: Float[np.ndarray, "a 5"], origin: Float[np.ndarray, "2"], directions: Float[np.ndarray, "m 2"]
) -> Float[np.ndarray, "m"]:
    """Distance along each ray to the nearest arc: the roots of |o + t·u − c|² = r² whose angle lies in the sweep."""
    if len(arcs) == 0:
        return np.full(len(directions), np.inf)
    off, radius, start, sweep = origin - arcs[:, :2], arcs[:, 2], arcs[:, 3], arcs[:, 4]
    half = directions @ off.T
    under_root = half**2 - (off**2).sum(1) + radius**2
    root = np.sqrt(np.where(under_root >= 0, under_root, np.nan))
    t = np.stack([-half - root, -half + root])
    end = off + t[..., None] * directions[:, None]
    turned = np.sign(sweep) * (np.arctan2(end[..., 1], end[..., 0]) - start) % (2 * np.pi)
    turned = np.where(turned > 2 * np.pi - NEAREST, 0.0, turned)
    hit = (t > NEAREST) & (turned <= np.abs(sweep) + NEAREST)
    return np.where(hit, t, np.inf).min(axis=(0, 2))


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


def _cross(a: Float[np.ndarray, "*a 2"], b: Float[np.ndarray, "*b 2"]) -> Float[np.ndarray, "*c"]:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
