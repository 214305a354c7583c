"""A picture for each step of an observation, turned as the map is."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.observation_steps import ObservedRelation
from splinescope.observation_view import ObservationStep, ObservationView
from splinescope.palette import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, Colour, LineStyle, Theme
from splinescope.pictures import drawing
from splinescope.pictures.drawing import LINE, WIDTH, Axes

MOST_ROWS = 36
"""Rows of the basis matrix that are drawn; of more, evenly chosen ones."""
READABLE = 26.0
"""How large (px) the largest ellipse is drawn at least; all are then drawn this many times too large."""
TIMES = (1, 2, 5, 10, 20, 50, 100)
TERMS = (("noise of the beams, P_s", SKY, LineStyle.SOLID), ("resolution, P_t1", ORANGE, LineStyle.DASHED),
         ("chord error, P_t2", PURPLE, LineStyle.DOTTED))  # fmt: skip


def observation_picture(view: ObservationView, step: ObservationStep, theme: Theme) -> str:
    """What one step looks like."""
    match step:
        case ObservationStep.PARAMETERS:
            return _parameters(view, theme)
        case ObservationStep.BASIS:
            return _basis(view, theme)
        case ObservationStep.CONTROL_POINTS:
            return _control_points(view, theme)
        case ObservationStep.COVARIANCE:
            return _covariance(view, theme)
        case ObservationStep.RELATION:
            return _relation(view.relation, view.pose, theme) if not isinstance(view.relation, str) else ""


def _world(view: ObservationView, points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
    return se2.transform(view.pose, points)


def _parameters(view: ObservationView, theme: Theme) -> str:
    """The points, the polygon of their chords, and where t passes its quarters."""
    points, t = _world(view, view.steps.points), view.steps.parameters
    axes = Axes.to_scale(points, tallest=250.0, margin=26.0)
    placed = axes.at(points)
    marked = np.array([int(np.argmin(np.abs(t - quarter))) for quarter in np.linspace(0.0, 1.0, 5)])
    sensor = axes.at(view.pose[None, :2])
    parts = [
        drawing.path(placed, theme.legible(GREY), 1.0),
        drawing.dots(placed, theme.legible(GREEN), 1.8),
        drawing.dots(placed[marked], theme.ink, 3.6, hollow=True),
        drawing.labels([f"{t[j]:.2f}" for j in marked], placed[marked], sensor, reach=15.0),
        drawing.scale_bar(axes),
    ]
    return drawing.picture(parts, axes.bottom, "Beam ends along the segment, with their chord-length parameters")


def _basis(view: ObservationView, theme: Theme) -> str:
    """Above the basis functions with a tick for each point, below the matrix as squares, its rows beside their t."""
    steps, n = view.steps, len(view.steps.curve.control_points)
    axes = Axes((0.0, 0.0), (1.0, 1.0), (24.0, 8.0, WIDTH - 8.0, 92.0))
    t = np.linspace(0.0, 1.0, 161)
    functions = steps.curve.basis(t)
    hues = [theme.spline(i) for i in range(n)]
    curves = [
        drawing.path(axes.at(np.stack([t[on], functions[on, i]], -1)), hues[i], 1.5)
        for i in range(n)
        for on in [_support(functions[:, i])]
    ]
    feet = axes.at(np.stack([steps.parameters, np.full(len(steps.parameters), -0.1)], -1))
    parts = [
        drawing.path(axes.at(np.array([[0.0, 0.0], [1.0, 0.0]])), theme.legible(GREY), 0.8),
        *curves,
        drawing.ticks(feet, theme.ink, 7.0, 0.8),
        *(drawing.words(f"{value:g}", x, 112.0, anchor="middle", dim=True)
          for value, x in ((0.0, 24.0), (0.5, 168.0), (1.0, WIDTH - 8.0))),
        drawing.words("t", 246.0, 112.0, dim=True),
        drawing.words("1", 20.0, 14.0, anchor="end", dim=True),
        *_matrix(steps.basis, hues, 124.0),
    ]  # fmt: skip
    rows = min(len(steps.basis), MOST_ROWS)
    return drawing.picture(parts, 142.0 + _row_height(rows) * rows, f"{n} basis functions and the rows of the matrix")


def _support(values: Float[np.ndarray, "s"]) -> slice:
    """Where a basis function lives, with the zeros at its ends."""
    on = np.flatnonzero(values > 0.0)
    return slice(max(int(on[0]) - 1, 0), int(on[-1]) + 2)


def _row_height(rows: int) -> float:
    return float(np.clip(150.0 / rows, 4.0, 12.0))


def _matrix(basis: Float[np.ndarray, "m n"], hues: list[Colour], top: float) -> list[str]:
    """Each entry as strong as it is large."""
    m, n = basis.shape
    shown = np.unique(np.linspace(0, m - 1, min(m, MOST_ROWS)).round().astype(int))
    left, height = 60.0, _row_height(len(shown))
    width = min((WIDTH - 8.0 - left) / n, 40.0)
    parts = []
    for row, j in enumerate(shown):
        y = top + 12.0 + height * row
        for i in np.flatnonzero(basis[j] > 5e-3):
            x = left + width * i
            square = np.array([[x, y], [x + width - 1, y], [x + width - 1, y + height - 0.5], [x, y + height - 0.5]])
            parts.append(drawing.area(square, hues[i], round(float(basis[j, i]), 2)))
        if row in (0, len(shown) - 1):
            parts.append(drawing.words(f"j = {j + 1}", left - 6.0, y + height, anchor="end", dim=True))
    every = 1 if width >= 14.0 else 2
    names = range(0, n, every)
    parts += [drawing.words(f"{i + 1}", left + width * (i + 0.5), top + 6.0, anchor="middle", dim=True) for i in names]
    return [*parts, drawing.words("i =", left - 6.0, top + 6.0, anchor="end", dim=True)]


def _control_points(view: ObservationView, theme: Theme) -> str:
    """Points, control polygon with numbers, and the curve."""
    axes, placed, parts = _fit(view, theme, 260.0)
    sensor = axes.at(view.pose[None, :2])
    named = drawing.apart(placed, 13.0)
    parts += [
        drawing.dots(placed, theme.legible(BLUE), 3.2, hollow=True),
        drawing.labels([str(i + 1) for i in named], placed[named], sensor),
        drawing.scale_bar(axes),
        drawing.legend(
            [
                ("control polygon", theme.legible(BLUE), LineStyle.DASHED),
                ("fitted curve", theme.ink, LineStyle.SOLID),
            ],
            axes.bottom + 12.0,
        ),
    ]
    return drawing.picture(
        parts, axes.bottom + 2 * LINE + 8.0, f"The fitted curve and its {len(placed)} control points"
    )


def _fit(view: ObservationView, theme: Theme, tallest: float) -> tuple[Axes, Float[np.ndarray, "n 2"], list[str]]:
    """Axes, control points in the picture, and beams, curve and control polygon as parts of it."""
    points, polygon = _world(view, view.steps.points), _world(view, view.steps.curve.control_points)
    curve = _world(view, view.steps.curve.sample(0.02)[1])
    axes = Axes.to_scale(np.concatenate([points, polygon]), tallest=tallest, margin=24.0)
    placed = axes.at(polygon)
    return axes, placed, [
        drawing.dots(axes.at(points), theme.legible(GREEN), 1.4),
        drawing.path(placed, theme.legible(BLUE), 1.0, LineStyle.DASHED),
        drawing.path(axes.at(curve), theme.ink, 1.3),
    ]  # fmt: skip


def _covariance(view: ObservationView, theme: Theme) -> str:
    """Around each control point a 2σ ellipse for each term."""
    axes, placed, parts = _fit(view, theme, 260.0)
    terms = view.steps.terms
    turn = se2.rotation(float(view.pose[2]))
    times = _times(float(np.linalg.eigvalsh(terms.total).max()), axes.scale)
    for (_, hue, style), blocks in zip(TERMS, (terms.noise, terms.resolution, terms.chord_error), strict=True):
        for centre, block in zip(placed, turn @ blocks @ turn.T, strict=True):
            if np.trace(block) > 1e-10:
                parts.append(
                    drawing.path(drawing.ellipse(centre, block, times * axes.scale), theme.legible(hue), 1.4, style)
                )
    entries = [(name, theme.legible(hue), style) for name, hue, style in TERMS]
    parts += [
        drawing.scale_bar(axes),
        drawing.legend(entries, axes.bottom + 12.0),
        drawing.words(_enlarged(times), WIDTH - 6.0, axes.bottom + 15.5, anchor="end", dim=True),
        drawing.words("2σ (86 %)", WIDTH - 6.0, axes.bottom + 15.5 + LINE, anchor="end", dim=True),
    ]
    return drawing.picture(parts, axes.bottom + 3 * LINE + 8.0, "Ellipses of the three terms around each control point")


def _times(variance: float, scale: float) -> int:
    """How many times too large ellipses are drawn so that they can be seen."""
    size = 2 * drawing.SIGMAS * float(np.sqrt(variance)) * scale
    return next((times for times in TIMES if times * size >= READABLE), TIMES[-1])


def _enlarged(times: int) -> str:
    return "ellipses to scale" if times == 1 else f"ellipses {times} × enlarged"


def _relation(seen: ObservedRelation, pose: Float[np.ndarray, "3"], theme: Theme) -> str:
    """The bearings of both ends of the data and of the full spline, from the sensor."""
    curve = seen.full_spline
    spline, data = (se2.transform(pose, points) for points in (curve.sample(0.03)[1], seen.points))
    ends = curve(np.array(curve.domain))
    hits = np.stack([seen.decision.start.hit, seen.decision.end.hit])
    corners = se2.transform(pose, np.concatenate([seen.points[[0, -1]], ends, hits]))
    axes = Axes.to_scale(np.concatenate([spline, data, pose[None, :2]]), tallest=250.0, margin=24.0)
    sensor, at = axes.at(pose[None, :2])[0], axes.at(corners)
    of_data, of_spline = theme.legible(VERMILION), theme.legible(BLUE)
    rays = [(at[0], of_data), (at[1], of_data), (at[2], of_spline), (at[3], of_spline)]
    parts = [
        *(drawing.path(np.stack([sensor, end]), hue, 1.0, LineStyle.SOLID if number < 2 else LineStyle.DASHED)
          for number, (end, hue) in enumerate(rays)),
        drawing.path(axes.at(spline), of_spline, 6.0),
        drawing.dots(axes.at(data), of_data, 1.5),
        drawing.dots(at[4:], theme.legible(ORANGE), 4.2, hollow=True),
        drawing.dots(sensor[None], theme.ink, 3.5),
        drawing.labels(["d_s", "d_e"], 0.4 * sensor + 0.6 * at[:2], at[[1, 0]], reach=10.0),
        drawing.labels(["s_s", "s_e"], at[2:4], sensor[None], reach=13.0),
        drawing.scale_bar(axes),
        drawing.legend(
            [
                ("data of this scan, rays to its ends", of_data, LineStyle.SOLID),
                ("full spline of the map, rays to its ends", of_spline, LineStyle.DASHED),
            ],
            axes.bottom + 12.0,
        ),
        drawing.dots(np.array([[20.0, axes.bottom + 12.0 + 2 * LINE]]), theme.legible(ORANGE), 4.2, hollow=True),
        drawing.words("where the end beams meet the full spline", 42.0, axes.bottom + 15.5 + 2 * LINE),
    ]  # fmt: skip
    return drawing.picture(parts, axes.bottom + 3 * LINE + 8.0, "Bearings of the ends of data and full spline")
