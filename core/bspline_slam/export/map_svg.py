"""A map as a drawing to scale: SVG in metres, with exact curves, the path of the robot, a grid and a scale bar."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline
from bspline_slam.spline_map import SplineMap

MARGIN = 1.0
WIDEST = 1400
STYLE = """
  svg { font-family: Helvetica, Arial, sans-serif; }
  .paper { fill: #fff; }
  .grid { fill: none; stroke: #e9edf2; stroke-width: 1; }
  .grid-5 { fill: none; stroke: #d3dae3; stroke-width: 1; }
  .splines path { fill: none; stroke: #16324f; stroke-width: 2.6; stroke-linecap: round; stroke-linejoin: round; }
  .trajectory { fill: none; stroke: #e69f00; stroke-width: 1.2; stroke-linejoin: round; }
  .start { fill: #e69f00; stroke: #fff; stroke-width: 1.5; }
  .bar { fill: none; stroke: #16324f; stroke-width: 2; }
  text { fill: #16324f; }
  .grid, .grid-5, .splines path, .trajectory, .start, .bar { vector-effect: non-scaling-stroke; }
"""


def map_to_svg(
    spline_map: SplineMap, path: Path, *, trajectory: Float[np.ndarray, "n 3"] | None = None, title: str = "Map"
) -> None:
    """Draw the supported stretches of all splines, and the trajectory; one user unit is one metre, y upwards."""
    curves = {spline.id: bezier_pieces(spline.curve, spline.span) for spline in spline_map}
    paths = [np.zeros((0, 2)) if trajectory is None else trajectory[:, :2]]
    low, high = _extent([*(pieces.reshape(-1, 2) for pieces in curves.values()), *paths])
    width, height = high - low
    scale = WIDEST / max(width, height)
    drawing = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{low[0]:g} {-high[1]:g} {width:g} {height:g}" '
        f'width="{width * scale:.0f}" height="{height * scale:.0f}">',
        f"<title>{escape(title)}</title>",
        f"<desc>One unit is one metre; y points upwards.</desc><style>{STYLE}</style>",
        f'<rect class="paper" x="{low[0]:g}" y="{-high[1]:g}" width="{width:g}" height="{height:g}"/>',
        '<g transform="scale(1,-1)">',
        *_grid(low, high),
        *_trajectory(paths[0], 4 / scale),
        '<g class="splines">',
        *(f'<path id="spline-{key}" d="{_path_data(pieces)}"/>' for key, pieces in curves.items()),
        "</g>",
        "</g>",
        *_scale_bar(low, high, 1 / scale),
        "</svg>",
    ]
    path.write_text("\n".join(drawing) + "\n", encoding="utf-8")


def bezier_pieces(curve: BSpline, span: tuple[float, float]) -> Float[np.ndarray, "pieces 4 2"]:
    """Cubic Bézier control points of each polynomial piece of the curve inside `span`.

    Exact up to degree 3 (a cubic is known by four of its points); a piece of a higher degree is met at four points.
    """
    a, b = max(span[0], curve.domain[0]), min(span[1], curve.domain[1])
    inner = curve.knots[(curve.knots > a) & (curve.knots < b)]
    breaks = np.unique(np.concatenate([[a], inner, [b]]))
    t = breaks[:-1, None] + np.diff(breaks)[:, None] * np.array([0.0, 1 / 3, 2 / 3, 1.0])
    p0, p1, p2, p3 = np.moveaxis(curve(t.ravel()).reshape(-1, 4, 2), 1, 0)
    return np.stack([p0, (-5 * p0 + 18 * p1 - 9 * p2 + 2 * p3) / 6, (2 * p0 - 9 * p1 + 18 * p2 - 5 * p3) / 6, p3], 1)


def _extent(
    point_sets: list[Float[np.ndarray, "_ 2"]],
) -> tuple[Float[np.ndarray, "2"], Float[np.ndarray, "2"]]:
    """Whole metres around everything drawn, with a margin."""
    points = np.concatenate([*point_sets, np.zeros((1, 2))])
    return np.floor(points.min(0) - MARGIN), np.ceil(points.max(0) + MARGIN)


def _path_data(pieces: Float[np.ndarray, "pieces 4 2"]) -> str:
    start = "M{:.3f} {:.3f}".format(*pieces[0, 0])
    return start + "".join("C{:.3f} {:.3f} {:.3f} {:.3f} {:.3f} {:.3f}".format(*piece[1:].ravel()) for piece in pieces)


def _grid(low: Float[np.ndarray, "2"], high: Float[np.ndarray, "2"]) -> list[str]:
    """Lines every metre, stronger ones every five."""
    data = {"grid": "", "grid-5": ""}
    for x in np.arange(low[0], high[0] + 0.5):
        data["grid-5" if x % 5 == 0 else "grid"] += f"M{x:g} {low[1]:g}V{high[1]:g}"
    for y in np.arange(low[1], high[1] + 0.5):
        data["grid-5" if y % 5 == 0 else "grid"] += f"M{low[0]:g} {y:g}H{high[0]:g}"
    return [f'<path class="{name}" d="{lines}"/>' for name, lines in data.items()]


def _trajectory(path: Float[np.ndarray, "n 2"], radius: float) -> list[str]:
    """The way of the robot, thinned to points that differ by a centimetre, and a dot where it began."""
    if len(path) == 0:
        return []
    centimetres = np.round(path, 2)
    moved = np.concatenate([[True], np.any(np.diff(centimetres, axis=0) != 0, axis=1)])
    points = " ".join(f"{x:g},{y:g}" for x, y in centimetres[moved])
    return [
        f'<polyline class="trajectory" points="{points}"/>',
        f'<circle class="start" cx="{path[0, 0]:.2f}" cy="{path[0, 1]:.2f}" r="{radius:.3f}"/>',
    ]


def _scale_bar(low: Float[np.ndarray, "2"], high: Float[np.ndarray, "2"], pixel: float) -> list[str]:
    """A bar of about a fifth of the width, in the lower left corner; `pixel` is the size of one in metres."""
    wanted = (high[0] - low[0]) / 5
    length = max(step for step in (1, 2, 5, 10, 20, 50, 100, 200, 500) if step <= max(wanted, 1))
    x, y, tick = low[0] + 16 * pixel, -low[1] - 16 * pixel, 5 * pixel
    return [
        f'<path class="bar" d="M{x:.3f} {y - tick:.3f}v{tick:.3f}h{length:g}v{-tick:.3f}"/>',
        f'<text x="{x + length / 2:.3f}" y="{y - 8 * pixel:.3f}" font-size="{15 * pixel:.3f}" '
        f'text-anchor="middle">{length:g} m</text>',
    ]
