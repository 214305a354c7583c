"""How far beams end from their curves: as a histogram over the map, and graded along the curves."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.lab.crispness import CLOSE
from splinescope.grades import RESIDUALS, WIDTHS
from splinescope.palette import BLUE, GREY, Theme
from splinescope.pictures import drawing
from splinescope.pictures.drawing import WIDTH, Axes
from splinescope.quality import EDGES

HEIGHT = 112.0
SIDE, TOP, BOTTOM = 12.0, 6.0, 84.0
ROW, BARS = 16.0, 140.0
TICKS = (-0.05, -CLOSE, 0.0, CLOSE, 0.05)


def residual_picture(histogram: Int[np.ndarray, "bins"], theme: Theme) -> str:
    """Bars over the distance from the curve, those within CLOSE strong, the others pale."""
    axes = Axes((EDGES[0], 0.0), (EDGES[-1], max(float(histogram.max()), 1.0)), (SIDE, TOP, WIDTH - SIDE, BOTTOM))
    middle = 0.5 * (EDGES[:-1] + EDGES[1:])
    near = np.abs(middle) < CLOSE
    parts = [
        *(_bar(axes, number, count, theme, bool(near[number])) for number, count in enumerate(histogram) if count),
        drawing.path(axes.at(np.array([[EDGES[0], 0.0], [EDGES[-1], 0.0]])), theme.legible(GREY), 1.0),
        *(_tick(axes, at) for at in TICKS),
        drawing.words("behind its curve", SIDE, HEIGHT - 3.0, dim=True),
        drawing.words("mm", WIDTH / 2, HEIGHT - 3.0, anchor="middle", dim=True),
        drawing.words("in front of it", WIDTH - SIDE, HEIGHT - 3.0, anchor="end", dim=True),
    ]
    label = f"Histogram of the distances of {histogram.sum():,} beam ends to their curves"
    return drawing.picture(parts, HEIGHT, label)


def grades_picture(shares: Float[np.ndarray, "grades"], theme: Theme) -> str:
    """The key to residuals along curves, a row for each grade, and the share of each as a bar."""
    parts = []
    for number, (label, width, share) in enumerate(zip(RESIDUALS.labels, WIDTHS, shares, strict=True)):
        y = ROW * (number + 0.5)
        colour = theme.graded(number)
        parts.append(drawing.path(np.array([[6.0, y], [38.0, y]]), colour, width))
        parts.append(drawing.words(label, 48.0, y + 3.5))
        reach = BARS + (WIDTH - BARS - 40.0) * float(share)
        corners = np.array([[BARS, y - 4.0], [reach, y - 4.0], [reach, y + 4.0], [BARS, y + 4.0]])
        parts.append(drawing.area(corners, theme.legible(GREY), 0.6))
        parts.append(drawing.words(f"{share:.0%}", reach + 5.0, y + 3.5, dim=True))
    return drawing.picture(parts, ROW * len(WIDTHS), "Share of the curves in each grade of residuals")


def _bar(axes: Axes, number: int, count: int, theme: Theme, near: bool) -> str:
    left, right = EDGES[number], EDGES[number + 1]
    corners = np.array([[left, 0.0], [left, count], [right, count], [right, 0.0]])
    return drawing.area(axes.at(corners) + _GAP, theme.legible(BLUE), 0.95 if near else 0.45)


_GAP: Float[np.ndarray, "4 2"] = np.array([[0.5, 0.0], [0.5, 0.0], [-0.5, 0.0], [-0.5, 0.0]])


def _tick(axes: Axes, at: float) -> str:
    x, y = axes.at(np.array([[at, 0.0]]))[0]
    anchor = "start" if at == TICKS[0] else "end" if at == TICKS[-1] else "middle"
    return drawing.words(f"{1000 * at:+.0f}" if at else "0", x, y + 13.0, anchor=anchor, dim=True)
