"""A small furnished room of straight walls and laser scans of it, and a twin with a room of curved ones, for tests."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.lab.simulation import OdometryModel
from bspline_slam.lab.twin import Twin
from bspline_slam.lab.twin_laser import TwinLaser
from bspline_slam.scan import LaserScan

ROOM = np.array(
    [
        [[0.0, 0.0], [6.0, 0.0]],
        [[6.0, 0.0], [6.0, 4.0]],
        [[6.0, 4.0], [2.5, 4.0]],
        [[2.5, 4.0], [2.5, 5.0]],
        [[2.5, 5.0], [0.0, 5.0]],
        [[0.0, 5.0], [0.0, 0.0]],
        [[4.0, 2.5], [4.6, 2.5]],
        [[4.6, 2.5], [4.6, 3.1]],
        [[4.6, 3.1], [4.0, 3.1]],
        [[4.0, 3.1], [4.0, 2.5]],
    ]
)
"""Walls (w, 2 ends, 2): an L-shaped room of 6 × 5 m with a box in it."""

LASER = np.array([0.1, 0.0, 0.0])


def room_scan(
    pose: Float[np.ndarray, "*beams 3"],
    rng: np.random.Generator,
    *,
    index: int = 0,
    noise: float = 0.01,
    walls: Float[np.ndarray, "w 2 2"] = ROOM,
    beams: int = 361,
) -> LaserScan:
    """What a laser with a field of view of 270° sees from a robot at `pose`, one or one for each beam."""
    bearings = np.linspace(-0.75 * np.pi, 0.75 * np.pi, beams)
    sensor = se2.compose(pose, LASER)
    angle = sensor[..., 2] + bearings
    u = np.stack([np.cos(angle), np.sin(angle)], -1)
    a, d = walls[:, 0] - sensor[..., None, :2], walls[:, 1] - walls[:, 0]
    cross = u[:, None, 0] * d[None, :, 1] - u[:, None, 1] * d[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = (a[..., 0] * d[:, 1] - a[..., 1] * d[:, 0]) / cross
        along = (a[..., 0] * u[:, None, 1] - a[..., 1] * u[:, None, 0]) / cross
    reach = np.where((along >= 0) & (along <= 1) & (reach > 0), reach, np.inf).min(1)
    ranges = reach + noise * rng.normal(size=beams)
    return LaserScan(index, 0.1 * index, ranges, bearings, 0.05, 20.0, LASER)


def loop_path(count: int) -> Float[np.ndarray, "n 3"]:
    """Poses around the box in the middle of the room and back to the start."""
    angle = np.linspace(0.0, 2 * np.pi, count)
    x, y = 3.0 + 1.9 * np.cos(angle - np.pi / 2), 2.0 + 1.2 * np.sin(angle - np.pi / 2)
    heading = np.arctan2(np.gradient(y), np.gradient(x))
    return np.stack([x, y, heading], -1)


def twin_room() -> Twin:
    """A drive of 5 m through a room of four curved walls."""
    corners = np.array([[-2.0, -2.0], [6.0, -2.5], [6.5, 2.5], [-2.5, 2.0]])
    walls = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        share = np.linspace(0.02, 0.98, 9)[:, None]
        bulge = 0.15 * np.sin(3 * np.pi * share) * (b - a)[::-1] / np.linalg.norm(b - a) * [-1, 1]
        walls.append(BSpline(3, clamped_knots(9), a + share * (b - a) + bulge))
    x = np.linspace(0.0, 5.0, 60)
    poses = np.stack([x, 0.3 * np.sin(x), np.arctan(0.3 * np.cos(x))], -1)
    laser = TwinLaser(np.radians(np.arange(-90.0, 90.0)), 0.05, 20.0, np.zeros(3))
    stamps = 100.0 + 0.2 * np.arange(60)
    return Twin("twin of a room", tuple(walls), stamps, poses, np.arange(60), laser, OdometryModel())
