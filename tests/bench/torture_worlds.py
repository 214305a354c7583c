"""Places unlike those that real logs at hand come from: a museum, convention halls, bare corridors.

Each function of `HALLS` makes a world with a laser and a drive in it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from bspline_slam.lab.drive import Drive
from bspline_slam.lab.world import Laser, World
from bspline_slam.lab.world_file import Shapes, box, circle, curved_wall, polyline, wall

Point = tuple[float, float]


def laser(
    field: float = 180.0,
    resolution: float = 1.0,
    reach: float = 30.0,
    pose: tuple[float, float, float] = (0.1, 0.0, 0.0),
) -> Laser:
    """A laser by degrees and metres."""
    x, y, turn = pose
    return Laser(np.radians(field), np.radians(resolution), 0.05, reach, np.array([x, y, np.radians(turn)]))


def world(
    name: str, shapes: Sequence[Shapes], seen_by: Laser, way: Sequence[Point], *, speed: float = 0.6,
    turn_rate: float = 40.0, period: float = 0.2,
) -> World:  # fmt: skip
    """Shapes, a laser, and a drive along straight lines between these points."""
    points: list[Point] = []
    for (ax, ay), (bx, by) in pairwise(way):
        n = max(round(float(np.hypot(bx - ax, by - ay))), 1)
        points += [(ax + (bx - ax) * k / n, ay + (by - ay) * k / n) for k in range(n)]
    drive = Drive(np.array([*points, way[-1]], dtype=float), speed, float(np.radians(turn_rate)), 0.5, period)
    return World(
        name,
        np.array([line for shape in shapes for line in shape.lines], dtype=float).reshape(-1, 2, 2),
        np.array([arc for shape in shapes for arc in shape.arcs], dtype=float).reshape(-1, 5),
        tuple(spline for shape in shapes for spline in shape.splines),
        seen_by,
        drive,
    )


def on_circle(radius: float, degrees: float) -> Point:
    """A point of a circle around the origin."""
    return float(radius * np.cos(np.radians(degrees))), float(radius * np.sin(np.radians(degrees)))


def museum(seen_by: Laser, **drive: float) -> World:
    """A round hall with columns and glass cases, a wing with partitions on both sides, a way around each."""
    rng = np.random.default_rng(5)
    columns = [circle(on_circle(10.0, a), 0.35) for a in range(15, 375, 30)]
    cases = [
        box((6 * np.cos(a), 6 * np.sin(a)), (1.2, 0.7), float(np.degrees(a)) + 20)
        for a in np.radians(np.arange(0, 360, 60))
    ]
    rotunda = [curved_wall((0, 0), 14, 8, 172, 0.4), curved_wall((0, 0), 14, 188, 352, 0.4)]
    wings: list[Shapes] = []
    for side in (-1, 1):
        wings += [polyline([(side * 13.8, y * 1.95), (side * 40, y * 1.95 * 3)]) for y in (-1, 1)]
        wings += [polyline([(side * 40, -5.85), (side * 40, 5.85)])]
        for x in range(18, 39, 5):
            y = float(rng.uniform(-1.0, 1.0))
            wings += [box((side * x, y), (0.3, 1.8), float(rng.uniform(-30, 30))), circle((side * (x + 2.5), -y), 0.3)]
    places, sizes = rng.uniform(-3.0, 3.0, (4, 2)), rng.uniform(0.2, 0.8, 4)
    exhibits = [circle(place, size) for place, size in zip(places.tolist(), sizes.tolist(), strict=True)]
    around = [on_circle(8.0, a) for a in range(0, 361, 15)]
    east = [(12.0, 0.0), (16.0, 1.9), (38.0, 3.6), (39.0, 0.0), (38.0, -3.6), (16.0, -1.9), (12.0, 0.0), (8.0, 0.0)]
    west = [(-x, y) for x, y in east]
    half = around[: len(around) // 2 + 1]
    way = [*around, *east, *half, *west, *around[len(around) // 2 :], *east[:3]]
    return world("museum", [*rotunda, *columns, *cases, *wings, *exhibits], seen_by, way, **drive)


def hall(seen_by: Laser, **drive: float) -> World:
    """A convention hall of 80 m × 60 m, rows of booths in it."""
    rng = np.random.default_rng(7)
    shapes = [polyline([(0, 0), (80, 0), (80, 60), (0, 60)], closed=True)]
    shapes += [box((x, y), (0.6, 0.6)) for x in range(10, 80, 20) for y in (15, 45)]
    for y in range(8, 56, 8):
        for x in range(8, 74, 6):
            if rng.random() < 0.6:
                shapes.append(
                    box(
                        (x + float(rng.uniform(-0.3, 0.3)), y + float(rng.uniform(-0.3, 0.3))),
                        (3.0, float(rng.uniform(2.0, 3.0))),
                    )
                )
    way = [
        (4.0, 4.0),
        (76.0, 4.0),
        (76.0, 20.0),
        (4.0, 20.0),
        (4.0, 36.0),
        (76.0, 36.0),
        (76.0, 52.0),
        (4.0, 52.0),
        (4.0, 4.0),
        (40.0, 4.0),
    ]
    return world("hall", shapes, seen_by, way, **drive)


def empty_hall(seen_by: Laser, **drive: float) -> World:
    """The same hall with hardly anything in it: a laser of 8 m sees nothing for long stretches."""
    shapes = [polyline([(0, 0), (80, 0), (80, 60), (0, 60)], closed=True)]
    shapes += [box((x, y), (0.8, 0.8), 10) for x in (20, 40, 60) for y in (20, 45)]
    way = [
        (3.0, 3.0),
        (40.0, 10.0),
        (70.0, 5.0),
        (75.0, 30.0),
        (40.0, 30.0),
        (5.0, 30.0),
        (5.0, 55.0),
        (75.0, 55.0),
        (40.0, 30.0),
        (3.0, 3.0),
        (40.0, 10.0),
    ]
    return world("empty hall", shapes, seen_by, way, **drive)


def corridors(seen_by: Laser, **drive: float) -> World:
    """A ring of bare corridors, 50 m × 30 m, with doors into two rooms."""
    outer = polyline([(0, 0), (50, 0), (50, 30), (0, 30)], closed=True)
    inner = polyline([(2.2, 2.2), (47.8, 2.2), (47.8, 27.8), (2.2, 27.8)], closed=True)
    way = [(1.1, 5.0), (1.1, 1.1), (48.9, 1.1), (48.9, 28.9), (1.1, 28.9), (1.1, 1.1), (30.0, 1.1)]
    return world("corridors", [outer, inner], seen_by, way, **drive)


def offices(seen_by: Laser, **drive: float) -> World:
    """Rooms on both sides of a corridor, each with its own clutter."""
    rng = np.random.default_rng(11)
    doors = [(x, 1.0) for x in (2.5, 7.5, 12.5, 17.5)]
    shapes = [polyline([(0, 0), (20, 0), (20, 12), (0, 12)], closed=True)]
    shapes += [wall([(0, 5), (20, 5)], 0.12, doors), wall([(0, 7), (20, 7)], 0.12, doors)]
    shapes += [wall([(x, y), (x, y + 5)], 0.12) for x in (5, 10, 15) for y in (0, 7)]
    way: list[Point] = [(0.8, 6.0)]
    for k, (x, _) in enumerate(doors):
        for low in (True, False):
            end, further = (1.6, 2.4) if low else (10.4, 9.6)
            way += [(x, 6.0), (x, end), (x + 1.2, end), (x + 1.2, further), (x, further), (x, 6.0)]
            for _ in range(4):
                at = (5.0 * k + float(rng.choice([0.6, 4.4])), float(rng.uniform(0.5, 3.5)) + (0.0 if low else 8.0))
                width, depth, turn = rng.uniform([0.3, 0.3, 0.0], [0.8, 0.8, 90.0]).tolist()
                shapes.append(box(at, (width, depth), turn))
    way += [(18.8, 6.0), (18.8, 6.4), (18.0, 6.4), (0.8, 6.0)]
    return world("offices", shapes, seen_by, way, **drive)


HALLS: dict[str, Callable[[], World]] = {
    "museum": lambda: museum(laser(180, 1.0, 80.0)),
    "museum, 360 beams": lambda: museum(laser(180, 0.5, 30.0)),
    "museum, all round, 8 m": lambda: museum(laser(360, 1.0, 8.0)),
    "hall, 80 m": lambda: hall(laser(180, 1.0, 80.0)),
    "hall, 8 m": lambda: hall(laser(180, 1.0, 8.0)),
    "empty hall, 80 m": lambda: empty_hall(laser(180, 1.0, 80.0)),
    "empty hall, 8 m": lambda: empty_hall(laser(180, 1.0, 8.0)),
    "bare corridors, 80 m": lambda: corridors(laser(180, 1.0, 80.0)),
    "bare corridors, 8 m": lambda: corridors(laser(180, 1.0, 8.0)),
    "offices": lambda: offices(laser(180, 1.0, 80.0)),
    "offices, all round": lambda: offices(laser(360, 1.0, 12.0, (-0.2, 0.1, 90.0))),
    "offices, turns of 90°/s": lambda: offices(laser(180, 0.5, 30.0), speed=1.0, turn_rate=90.0, period=0.1),
}
