"""Wings of corridors and rooms around courts, so large that a robot comes back many metres off: across a court no wall
is near enough to tell where it goes, and along a bare corridor only wheels tell how far."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from bench.torture_rings import rectangle, various, walls
from bench.torture_worlds import Point, laser, world
from bspline_slam.lab.world import Laser, World
from bspline_slam.lab.world_file import box, wall


def court(seen_by: Laser, **drive: float) -> World:
    """A ring of corridors, 80 m × 100 m, around an empty court: a stretch of it, across the court, on around it."""
    rng = np.random.default_rng(21)
    x, y, w, gate = 80.0, 100.0, 3.0, 60.0
    shapes = [walls(rectangle(0, 0, x, y, inside=True), various(rng, 5.0))]
    inner = rectangle(w, w, x - w, y - w, inside=False)
    for k, (start, end) in enumerate(pairwise([*inner, inner[0]])):
        upright = start[0] == end[0]
        gates = [(gate - 1.5 - w, 3.0) if start[1] < end[1] else (y - w - gate - 1.5, 3.0)] if upright else []
        shapes.append(wall([start, end], 0.12, gates))
        shapes += [box((9.0 + 12.0 * m, w - 0.2 if k < 2 else y - w + 0.2), (0.5, 0.4)) for m in range(5)]
    h = w / 2
    way: list[Point] = [
        (70.0, h), (h, h), (h, gate), (x - h, gate), (x - h, h), (h, h), (h, y - h), (x - h, y - h), (x - h, h),
        (40.0, h),
    ]  # fmt: skip
    return world("court", shapes, seen_by, way, **drive)


def wings(seen_by: Laser, **drive: float) -> World:
    """Two rings of bare corridors that share a side, 200 m × 90 m in all; rooms with clutter open here and there."""
    rng = np.random.default_rng(22)
    w, x, y, middle = 2.4, 200.0, 90.0, 110.0
    rare = various(rng, 25.0)
    shapes = [
        walls(rectangle(0, 0, x, y, inside=True), rare),
        walls(rectangle(w, w, middle - w / 2, y - w, inside=False), rare),
        walls(rectangle(middle + w / 2, w, x - w, y - w, inside=False), rare),
    ]
    h = w / 2
    way: list[Point] = [
        (20.0, h), (x - h, h), (x - h, y - h), (h, y - h), (h, h), (middle, h), (middle, y - h), (h, y - h), (h, h),
        (60.0, h),
    ]  # fmt: skip
    return world("wings", shapes, seen_by, way, **drive)


QUICK = {"speed": 1.0, "turn_rate": 60.0, "period": 0.4}
COURTS: dict[str, Callable[[], World]] = {
    "court, 20 m": lambda: court(laser(180, 1.0, 20.0), **QUICK),
    "court, all round, 15 m": lambda: court(laser(360, 1.0, 15.0), **QUICK),
    "wings, 80 m": lambda: wings(laser(180, 1.0, 80.0), **QUICK),
    "wings, 12 m": lambda: wings(laser(270, 0.5, 12.0), **QUICK),
}
