"""Buildings that a robot comes around in hundreds of metres later: corridors that all look alike, halls in a row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from bench.torture_worlds import Point, laser, world
from bspline_slam.lab.world import Laser, World
from bspline_slam.lab.world_file import Shapes, box, circle, polyline

Doors = Callable[[float], list[tuple[float, float, float]]]
"""Where doors stand along a wall of some length: (distance of the near jamb, width, how far the door is set back)."""


def alike(pitch: float = 4.0, width: float = 0.9, back: float = 0.12) -> Doors:
    """The same door at the same distance, again and again."""
    return lambda length: [(at, width, back) for at in np.arange(pitch / 2, length - width, pitch)]


def various(rng: np.random.Generator, every: float = 6.0) -> Doors:
    """Doors, niches and open rooms at any distance."""

    def doors(length: float) -> list[tuple[float, float, float]]:
        at, found = float(rng.uniform(0.5, every)), []
        while at + 2.0 < length:
            width, back = float(rng.uniform(0.7, 1.6)), float(rng.choice([0.1, 0.15, 0.4, 1.5]))
            found.append((at, width, back))
            at += width + float(rng.uniform(0.3, 2.0)) * every
        return found

    return doors


def walls(corners: Sequence[Point], doors: Doors) -> Shapes:
    """A closed wall whose doors are set back to the right of its direction."""
    points: list[Point] = []
    for start, end in pairwise([*corners, corners[0]]):
        a, b = np.array(start), np.array(end)
        length = float(np.linalg.norm(b - a))
        along = (b - a) / length
        right = np.array([along[1], -along[0]])
        points.append(start)
        for at, width, back in doors(length):
            near, far = a + at * along, a + (at + width) * along
            points += [tuple(p.tolist()) for p in (near, near + back * right, far + back * right, far)]
    return polyline(points, closed=True)


def rectangle(x: float, y: float, to_x: float, to_y: float, *, inside: bool) -> list[Point]:
    """Corners of a rectangle so that doors are set back away from the corridor, which lies `inside` it or around."""
    around = [(x, y), (to_x, y), (to_x, to_y), (x, to_y)]
    return around if inside else around[::-1]


def endless_corridor(seen_by: Laser, doors: Doors, **drive: float) -> World:
    """Two rings of corridors, 90 m × 50 m in all, that share a side: around the whole, then through the middle and
    around one ring the other way."""
    w, x, y, middle = 2.4, 90.0, 50.0, 50.0
    shapes = [
        walls(rectangle(0, 0, x, y, inside=True), doors),
        walls(rectangle(w, w, middle - w / 2, y - w, inside=False), doors),
        walls(rectangle(middle + w / 2, w, x - w, y - w, inside=False), doors),
    ]
    h = w / 2
    way = [
        (h + 3.0, h), (x - h, h), (x - h, y - h), (h, y - h), (h, h), (middle, h), (middle, y - h), (h, y - h), (h, h),
        (20.0, h),
    ]  # fmt: skip
    return world("endless corridor", shapes, seen_by, way, **drive)


def convention_centre(seen_by: Laser, **drive: float) -> World:
    """Three large halls in a row, a long lobby before them with columns, doors between: 120 m × 55 m."""
    rng = np.random.default_rng(3)
    shapes = [polyline([(0, 0), (120, 0), (120, 55), (0, 55)], closed=True)]
    for x in (0, 40, 80):
        for a, b in ((0, 8), (12, 28), (32, 40)):
            shapes.append(box((x + (a + b) / 2, 15.0), (b - a, 0.3)))
        if x:
            shapes += [box((x, y), (0.3, length)) for y, length in ((20.0, 10.0), (42.0, 26.0))]
        for k in range(14):
            place = (x + float(rng.uniform(5, 35)), float(rng.uniform(21, 50)))
            size = (float(rng.uniform(0.5, 3)), float(rng.uniform(0.5, 3)))
            if abs(place[1] - 26.5) > 4 and min(abs(place[0] - x - 10), abs(place[0] - x - 30)) > 3.5:
                shapes.append(box(place, size, float(rng.uniform(0, 90)) if k % 2 else 0.0))
    shapes += [circle((x, y), 0.4) for x in range(4, 120, 12) for y in (4.5, 11.5)]
    way = [
        (3.0, 8.0), (10.0, 8.0), (10.0, 26.5), (10.0, 48.0), (30.0, 48.0), (30.0, 26.5), (40.0, 26.5), (50.0, 26.5),
        (50.0, 45.0), (70.0, 45.0), (70.0, 26.5), (80.0, 26.5), (90.0, 26.5), (90.0, 48.0), (110.0, 48.0),
        (110.0, 8.0), (30.0, 8.0), (30.0, 26.5), (10.0, 26.5), (10.0, 8.0), (60.0, 8.0),
    ]  # fmt: skip
    return world("convention centre", shapes, seen_by, way, **drive)


RINGS: dict[str, Callable[[], World]] = {
    "endless corridor": lambda: endless_corridor(laser(180, 1.0, 80.0), various(np.random.default_rng(1))),
    "endless corridor, alike": lambda: endless_corridor(laser(180, 1.0, 80.0), alike()),
    "convention centre": lambda: convention_centre(laser(180, 1.0, 80.0)),
    "convention centre, 270°": lambda: convention_centre(laser(270, 0.5, 30.0)),
}
