"""World files: a JSON text with a laser, a drive and a list of shapes, read into a World.

    {
      "name": "two rooms",
      "laser": {"field_of_view": 180, "resolution": 1, "range_max": 15, "pose": [0.1, 0, 0]},
      "drive": {"way_points": [[1, 1], [2, 1], [4, 1], [6, 2]], "speed": 0.5, "turn_rate": 25, "scan_period": 0.4},
      "shapes": [
        {"shape": "wall", "name": "between", "ends": [[3, 0], [3, 5]], "thickness": 0.12, "doors": [[1, 1.1]]},
        {"shape": "spline", "control_points": [[0, 0], [1, 0.4], [2, -0.3], [3, 0]]}
      ]
    }

Metres and seconds; angles in degrees. A shape has an optional "name" and the keys of its function below: `polyline`,
`wall`, `box`, `arc`, `curved_wall`, `circle`, `spline`.
"""

from __future__ import annotations

import inspect
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots, uniform_knots
from bspline_slam.errors import ConfigError, GeometryError
from bspline_slam.lab.drive import Drive
from bspline_slam.lab.world import Laser, World

Point = Sequence[float]
Pose = Sequence[float]


@dataclass(frozen=True, slots=True)
class Shapes:
    """What a shape is made of: lines (start, end), arcs (x, y, radius, start, sweep), splines."""

    lines: tuple[Any, ...] = ()
    arcs: tuple[Any, ...] = ()
    splines: tuple[BSpline, ...] = ()


def polyline(points: Sequence[Point], closed: bool = False) -> Shapes:
    """Straight lines from point to point."""
    corners = _points(points, 2)
    ends = np.vstack([corners[1:], corners[:1]]) if closed else corners[1:]
    return Shapes(lines=tuple(zip(corners, ends, strict=False)))


def wall(ends: Sequence[Point], thickness: float = 0.15, doors: Sequence[Point] = ()) -> Shapes:
    """A straight wall with thickness; `doors` are openings (distance of their middle from the first end, width)."""
    start, end = _points(ends, 2, 2)
    length = float(np.linalg.norm(end - start))
    if length == 0 or thickness <= 0:
        raise GeometryError("its two ends must lie apart and its thickness must be positive")
    gaps = sorted((at - width / 2, at + width / 2) for at, width in doors)
    cuts = [0.0, *(side for gap in gaps for side in gap), length]
    if any(b < a for a, b in pairwise(cuts)):
        raise GeometryError(f"its doors overlap or lie beyond its length of {length:g} m")
    heading = float(np.degrees(np.arctan2(*(end - start)[::-1])))
    along = (end - start) / length
    pieces = [
        box((start + along * (a + b) / 2).tolist(), (b - a, thickness), heading)
        for a, b in zip(cuts[::2], cuts[1::2], strict=True)
        if b > a
    ]
    return Shapes(lines=tuple(line for piece in pieces for line in piece.lines))


def box(centre: Point, size: Point, turn: float = 0.0) -> Shapes:
    """A rectangle, `size` along its own x and y axes, turned counter-clockwise by `turn` degrees."""
    if min(size) <= 0:
        raise GeometryError(f"its size must be positive, got {size[0]:g} by {size[1]:g}")
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * size
    return polyline(se2.transform(np.array([*centre, np.radians(turn)]), corners).tolist(), closed=True)


def arc(centre: Point, radius: float, start: float, end: float) -> Shapes:
    """A part of a circle, counter-clockwise from the angle `start` to `end` (degrees; clockwise when end < start)."""
    if radius <= 0:
        raise GeometryError(f"its radius must be positive, got {radius:g}")
    if start == end:
        raise GeometryError(f"it starts and ends at the same angle of {start:g}°")
    return Shapes(arcs=((*centre, radius, np.radians(start), np.radians(end - start)),))


def curved_wall(centre: Point, radius: float, start: float, end: float, thickness: float = 0.15) -> Shapes:
    """A wall along an arc: two arcs half a thickness beside it, closed at both ends."""
    inner = arc(centre, radius - thickness / 2, start, end)
    outer = arc(centre, radius + thickness / 2, start, end)
    middle = np.asarray(centre, dtype=float)
    rays = [np.array([np.cos(angle), np.sin(angle)]) for angle in np.radians([start, end])]
    reach = radius + thickness * np.array([[-0.5], [0.5]])
    return Shapes(lines=tuple(middle + reach * ray for ray in rays), arcs=inner.arcs + outer.arcs)


def circle(centre: Point, radius: float) -> Shapes:
    """A whole circle: a pillar, a round table."""
    return arc(centre, radius, 0.0, 360.0)


def spline(control_points: Sequence[Point], degree: int = 3, closed: bool = False) -> Shapes:
    """A B-spline with uniform knots, clamped at its ends or closed smoothly onto itself."""
    if degree < 1:
        raise GeometryError(f"its degree must be at least 1, got {degree}")
    points = _points(control_points, degree + 1)
    if not closed:
        return Shapes(splines=(BSpline(degree, clamped_knots(len(points), degree), points),))
    around = np.vstack([points, points[:degree]])
    return Shapes(splines=(BSpline(degree, uniform_knots(0.0, 1.0, len(around), degree), around),))


SHAPES: dict[str, Callable[..., Shapes]] = {
    builder.__name__: builder for builder in (polyline, wall, box, arc, curved_wall, circle, spline)
}


def built_in_worlds() -> tuple[str, ...]:
    """Names of the worlds that come with the library."""
    files = resources.files("bspline_slam.lab").joinpath("worlds").iterdir()
    return tuple(sorted(file.name.removesuffix(".json") for file in files if file.name.endswith(".json")))


def open_world(world: str | Path) -> World:
    """The world of that name, or of that file; ConfigError when there is neither or the file is not a world."""
    if str(world) in built_in_worlds():
        text = resources.files("bspline_slam.lab").joinpath("worlds", f"{world}.json").read_text("utf-8")
        return parse_world(text, f"{world}.json")
    path = Path(world)
    if not path.is_file():
        known = ", ".join(built_in_worlds())
        raise ConfigError(f"there is no world or world file called {world}; the built-in worlds are {known}")
    try:
        return parse_world(path.read_text("utf-8"), path.name)
    except UnicodeDecodeError:
        raise ConfigError(f"{path.name} is not a text file") from None


def parse_world(text: str, source: str) -> World:
    """The world that a JSON text describes; `source` names it in errors."""
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise ConfigError(f"{source}:{error.lineno}: not valid JSON: {error.msg}") from None
    if not isinstance(content, dict) or not {"laser", "drive", "shapes"} <= content.keys():
        raise ConfigError(f"{source}: a world needs the keys laser, drive and shapes")
    if not isinstance(content["shapes"], list) or not content["shapes"]:
        raise ConfigError(f"{source}: shapes must be a list of at least one shape")
    shapes = [_shape(item, f"{source}: shape {i + 1}") for i, item in enumerate(content["shapes"])]
    return World(
        name=str(content.get("name", Path(source).stem)),
        lines=np.array([line for shape in shapes for line in shape.lines], dtype=float).reshape(-1, 2, 2),
        arcs=np.array([arc for shape in shapes for arc in shape.arcs], dtype=float).reshape(-1, 5),
        splines=tuple(spline for shape in shapes for spline in shape.splines),
        laser=_call(_laser, content["laser"], f"{source}: laser"),
        drive=_call(_drive, content["drive"], f"{source}: drive"),
    )


def _laser(
    field_of_view: float = 180.0,
    resolution: float = 1.0,
    range_min: float = 0.05,
    range_max: float = 30.0,
    pose: Pose = (0.0, 0.0, 0.0),
) -> Laser:
    if not 0 < resolution <= field_of_view <= 360:
        raise GeometryError(f"resolution {resolution:g}° and field of view {field_of_view:g}° do not go together")
    if not 0 <= range_min < range_max:
        raise GeometryError(f"range_max {range_max:g} must exceed range_min {range_min:g}")
    x, y, turn = pose
    sensor = np.array([x, y, np.radians(turn)], dtype=float)
    return Laser(float(np.radians(field_of_view)), float(np.radians(resolution)), range_min, range_max, sensor)


def _drive(
    way_points: Sequence[Point],
    speed: float = 0.5,
    turn_rate: float = 30.0,
    acceleration: float = 0.5,
    scan_period: float = 0.4,
) -> Drive:
    for name, value in {
        "speed": speed,
        "turn_rate": turn_rate,
        "acceleration": acceleration,
        "scan_period": scan_period,
    }.items():
        if value <= 0:
            raise GeometryError(f"{name} must be positive, got {value:g}")
    points = _points(way_points, 4)
    if not np.ptp(points, axis=0).any():
        raise GeometryError("its way points all lie on one place")
    return Drive(points, speed, float(np.radians(turn_rate)), acceleration, scan_period)


def _shape(item: Any, place: str) -> Shapes:
    """One entry of the list of shapes."""
    kind = item.get("shape") if isinstance(item, dict) else None
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ConfigError(f'{place}: "shape" must be one of {", ".join(SHAPES)}')
    named = f"{place} ({item['name']})" if "name" in item else place
    return _call(SHAPES[kind], {k: v for k, v in item.items() if k not in ("shape", "name")}, named)


def _call(build: Callable[..., Any], keys: Any, place: str) -> Any:
    """build(**keys), with everything that is wrong with the keys said as one sentence."""
    if not isinstance(keys, dict):
        raise ConfigError(f"{place}: expected an object with keys, got {type(keys).__name__}")
    known = inspect.signature(build).parameters
    required = {name for name, parameter in known.items() if parameter.default is inspect.Parameter.empty}
    if unknown := sorted(keys.keys() - known.keys()):
        raise ConfigError(f"{place}: unknown key {unknown[0]}; known are {', '.join(known)}")
    if missing := sorted(required - keys.keys()):
        raise ConfigError(f"{place}: the key {missing[0]} is missing")
    for name, value in keys.items():
        fits, what = VALUES[known[name].annotation]
        if not fits(value):
            raise ConfigError(f"{place}: {name} must be {what}, got {json.dumps(value)}")
    try:
        return build(**keys)
    except GeometryError as error:
        raise ConfigError(f"{place}: {error}") from None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _are_numbers(value: Any, count: int) -> bool:
    return isinstance(value, list) and len(value) == count and all(map(_is_number, value))


VALUES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "float": (_is_number, "a number"),
    "int": (lambda value: _is_number(value) and isinstance(value, int), "a whole number"),
    "bool": (lambda value: isinstance(value, bool), "true or false"),
    "Point": (lambda value: _are_numbers(value, 2), "a pair of numbers"),
    "Pose": (lambda value: _are_numbers(value, 3), "three numbers"),
    "Sequence[Point]": (
        lambda value: isinstance(value, list) and all(_are_numbers(point, 2) for point in value),
        "a list of pairs of numbers",
    ),
}
"""What a world file may say for a parameter annotated so: the check, and its words."""


def _points(points: Sequence[Point], at_least: int, at_most: int | None = None) -> Float[np.ndarray, "n 2"]:
    if len(points) < at_least or (at_most is not None and len(points) > at_most):
        wanted = f"{'exactly' if at_least == at_most else 'at least'} {at_least} points"
        raise GeometryError(f"it needs {wanted}, got {len(points)}")
    return np.array(points, dtype=float)
