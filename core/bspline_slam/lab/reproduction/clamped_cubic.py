"""Fig. 1: a clamped cubic spline with its knots and control points."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.export import figure as fig
from bspline_slam.lab.reproduction.reproduced import Reproduced, Row, write_data

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CURVE = BSpline(
    3,
    clamped_knots(11),
    np.array([
        [0.0, 0.0], [0.5, 1.3], [1.6, 1.9], [2.6, 0.7], [3.4, -0.4], [4.6, -0.2],
        [5.2, 1.2], [6.3, 2.2], [7.4, 1.6], [7.8, 0.4], [9.0, 0.1],
    ]),
)  # fmt: skip


def reproduce(out: Path) -> Reproduced:
    """Draw the spline and its basis functions."""
    inner = np.unique(CURVE.knots)
    gap = np.linalg.norm(CURVE(np.array(CURVE.domain)) - CURVE.control_points[[0, -1]], axis=1).max()
    stem = out / "figure_1"
    files = fig.draw("Fig. 1 · A clamped B-spline of order 4", [_curve, _basis], stem)
    data = write_data(
        stem, {"degree": CURVE.degree, "knots": CURVE.knots, "control_points": CURVE.control_points, "end_gap_m": gap}
    )
    rows = (
        Row("1", "knot vector", "0 ×4, 0.125 … 0.875, 1 ×4", _knots_text(inner)),
        Row("1", "curve ends to first and last control point (m)", "0", f"{gap:.1g}" if gap > 0 else "0"),
    )
    return Reproduced(rows, (*files, data))


def _knots_text(inner: np.ndarray) -> str:
    repeats = [int(np.sum(CURVE.knots == knot)) for knot in inner[[0, -1]]]
    return f"{inner[0]:g} ×{repeats[0]}, {inner[1]:g} … {inner[-2]:g}, {inner[-1]:g} ×{repeats[1]}"


def _curve(axes: Axes) -> None:
    fig.to_scale(axes, "Curve, control polygon, knots")
    fig.line(axes, CURVE.control_points, fig.GREY, linewidth=0.8, linestyle="--")
    fig.line(axes, CURVE.sample(0.02)[1], fig.BLUE, "curve", linewidth=2.2)
    fig.dots(axes, CURVE(np.unique(CURVE.knots)), fig.INK, "knots", marker="|", markersize=11, markeredgewidth=1.6)
    fig.dots(axes, CURVE.control_points, fig.RED, "control points", markersize=6, markerfacecolor="none")
    fig.legend(axes)


def _basis(axes: Axes) -> None:
    axes.set_title("Its basis functions")
    t = np.linspace(*CURVE.domain, 401)
    for column in CURVE.basis(t).T:
        shown = column > 0
        fig.line(axes, np.stack([t[shown], column[shown]], -1), fig.BLUE, linewidth=1.2)
    knots = np.unique(CURVE.knots)
    fig.dots(axes, np.stack([knots, 0 * knots], -1), fig.INK, marker="|", markersize=9)
    axes.set_xlabel("t")
    axes.set_ylabel("β(t)")
