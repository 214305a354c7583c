"""Figures on paper: a plain style over matplotlib, written as SVG and PNG. matplotlib is loaded by the first figure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, GREY, PALE = "#16324f", "#8593a3", "#d3dae3"
BLUE, ORANGE, GREEN, RED, PURPLE = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#a3568c"
STYLE: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#e9edf2",
    "xtick.color": GREY,
    "ytick.color": GREY,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.solid_capstyle": "round",
    "svg.hashsalt": "splinescope",
    "svg.fonttype": "path",
}

Painter = Callable[["Axes"], None]


def draw(title: str, panels: Sequence[Painter], stem: Path, columns: int = 2, height: float = 4.0) -> list[Path]:
    """Draw panels side by side, `columns` in a row, and write `stem`.svg and .png; returns the two files.

    Each painter fills one pair of axes; a row is `height` inches high and a page 5.2 inches per column wide. The same
    drawing gives the same files.
    """
    import matplotlib
    from matplotlib.figure import Figure

    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    with matplotlib.rc_context(STYLE):
        figure: Figure = Figure(figsize=(5.2 * columns, height * rows + 0.4), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, paint in zip(grid, panels, strict=False):
            paint(axes)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        return _write(figure, stem)


def _write(figure: Figure, stem: Path) -> list[Path]:
    stem.parent.mkdir(parents=True, exist_ok=True)
    files = [stem.with_suffix(".svg"), stem.with_suffix(".png")]
    figure.savefig(files[0], metadata={"Date": None})
    figure.savefig(files[1], dpi=150, metadata={"Software": None})
    return files


def to_scale(axes: Axes, title: str) -> None:
    """A map: metres on both axes, equally long."""
    axes.set_title(title)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")


def legend(axes: Axes, columns: int = 3) -> None:
    """The labels of what was drawn, below the axes where they hide nothing."""
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=columns)


def line(axes: Axes, points: Float[np.ndarray, "n 2"], colour: str, label: str = "", **look: Any) -> None:
    """A polyline; `look` are matplotlib's names for width and style."""
    axes.plot(points[:, 0], points[:, 1], color=colour, label=label or None, **_given(look, linewidth=1.6))


def dots(axes: Axes, points: Float[np.ndarray, "n 2"], colour: str, label: str = "", **look: Any) -> None:
    """Points; `look` are matplotlib's names for marker and size."""
    drawn = _given(look, marker="o", markersize=3.0, linestyle="none")
    axes.plot(points[:, 0], points[:, 1], color=colour, label=label or None, **drawn)


def ellipse(
    axes: Axes, centre: Float[np.ndarray, "2"], covariance: Float[np.ndarray, "2 2"], colour: str, sigmas: float = 2.0
) -> None:
    """The ellipse of `sigmas` standard deviations around a point."""
    around = np.linspace(0.0, 2 * np.pi, 73)
    values, vectors = np.linalg.eigh(covariance)
    radii = sigmas * np.sqrt(np.maximum(values, 0.0))
    points = centre + np.stack([np.cos(around), np.sin(around)], -1) * radii @ vectors.T
    axes.plot(points[:, 0], points[:, 1], color=colour, linewidth=0.9)


def robot(axes: Axes, pose: Float[np.ndarray, "3"], colour: str, label: str = "", size: float = 0.2) -> None:
    """A robot as a triangle that points where it looks."""
    corners = size * np.array([[1.0, 0.0], [-0.7, 0.6], [-0.7, -0.6], [1.0, 0.0]])
    c, s = np.cos(pose[2]), np.sin(pose[2])
    points = pose[:2] + corners @ np.array([[c, s], [-s, c]])
    axes.fill(points[:, 0], points[:, 1], facecolor=colour, edgecolor="white", linewidth=0.6, label=label or None)


def rays(
    axes: Axes, origin: Float[np.ndarray, "2"], ends: Float[np.ndarray, "n 2"], colour: str = PALE, **look: Any
) -> None:
    """Beams from one origin to their ends."""
    path = np.full((3 * len(ends), 2), np.nan)
    path[0::3], path[1::3] = origin, ends
    axes.plot(path[:, 0], path[:, 1], color=colour, **_given(look, linewidth=0.5))


def _given(look: dict[str, Any], **defaults: Any) -> dict[str, Any]:
    return defaults | look
