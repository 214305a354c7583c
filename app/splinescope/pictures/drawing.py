"""Small pictures for the side bar, as SVG text: axes that place data, and lines, dots, words and ellipses on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil

import numpy as np
from jaxtyping import Float

from splinescope.palette import Colour, LineStyle, hexadecimal
from splinescope.typeset import typeset

WIDTH = 320.0
"""Of every picture (in its own units, about a pixel each where the side bar is as wide as it begins)."""
SIGMAS = 2.0
FONT = 10.5
LINE = 15.0

Points = Float[np.ndarray, "n 2"]


@dataclass(frozen=True, slots=True)
class Axes:
    """The rectangle from `low` to `high` of the data fills the box (left, top, right, bottom); y of the data points up.

    In data that are drawn on a logarithmic scale `low` and `high` are logarithms.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    box: tuple[float, float, float, float]

    @classmethod
    def to_scale(cls, points: Points, width: float = WIDTH, tallest: float = 240.0, margin: float = 16.0) -> Axes:
        """Both axes in the same scale, all points inside, the box as high as they need."""
        low, high = points.min(axis=0), points.max(axis=0)
        extent = np.maximum(high - low, 1e-3)
        scale = float(min((width - 2 * margin) / extent[0], (tallest - 2 * margin) / extent[1]))
        height = max(extent[1] * scale, 60.0) + 2 * margin
        middle, half = 0.5 * (low + high), 0.5 * np.array([width, height]) / scale
        (left, bottom), (right, top) = middle - half, middle + half
        return cls((left, bottom), (right, top), (0.0, 0.0, width, float(ceil(height))))

    @property
    def scale(self) -> float:
        """Pixels per unit across."""
        return (self.box[2] - self.box[0]) / (self.high[0] - self.low[0])

    @property
    def bottom(self) -> float:
        return self.box[3]

    def at(self, points: Points) -> Points:
        """Where data lie in the picture."""
        left, top, right, bottom = self.box
        share = (points - self.low) / np.subtract(self.high, self.low)
        return np.stack([left + share[:, 0] * (right - left), bottom - share[:, 1] * (bottom - top)], axis=-1)


def picture(parts: Iterable[str], height: float, label: str) -> str:
    """The whole picture as text for an HTML page; `label` says in words what it shows."""
    return (
        f'<svg class="drawing" viewBox="0 0 {WIDTH:g} {height:g}" role="img" aria-label="{escape(label)}" '
        f'font-size="{FONT}" fill="currentColor">{"".join(parts)}</svg>'
    )


def path(points: Points, colour: Colour, width: float = 1.5, style: LineStyle = LineStyle.SOLID) -> str:
    """A polyline through points of the picture."""
    dashes = f' stroke-dasharray="{" ".join(f"{0.6 * length:g}" for length in style.pattern)}"' if style.pattern else ""
    return (
        f'<polyline fill="none" stroke="{hexadecimal(colour)}" stroke-width="{width:g}" stroke-linejoin="round"'
        f'{dashes} points="{_coordinates(points)}"/>'
    )


def area(points: Points, colour: Colour, opacity: float) -> str:
    """A filled polygon."""
    return f'<polygon fill="{hexadecimal(colour)}" opacity="{opacity:g}" points="{_coordinates(points)}"/>'


def dots(points: Points, colour: Colour, radius: float = 2.0, *, hollow: bool = False) -> str:
    """A dot at each point."""
    tone = hexadecimal(colour)
    look = f'fill="none" stroke="{tone}" stroke-width="1.3"' if hollow else f'fill="{tone}"'
    circles = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}"/>' for x, y in points)
    return f"<g {look}>{circles}</g>"


def ticks(points: Points, colour: Colour, length: float = 5.0, width: float = 1.0) -> str:
    """A short upright line that ends at each point."""
    lines = "".join(f"M{x:.1f} {y:.1f}v{-length:g}" for x, y in points)
    return f'<path stroke="{hexadecimal(colour)}" stroke-width="{width:g}" d="{lines}"/>'


def words(
    text: str, x: float, y: float, *, anchor: str = "start", colour: Colour | None = None, dim: bool = False
) -> str:
    """A line of text; `anchor` is start, middle or end."""
    tone = f' fill="{hexadecimal(colour)}"' if colour is not None else ""
    faint = ' opacity="0.72"' if dim else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{tone}{faint}>{escape(typeset(text))}</text>'


def labels(texts: Sequence[str], points: Points, away_from: Float[np.ndarray, "_ 2"], reach: float = 11.0) -> str:
    """A text beside each point, on the side that looks away from its own other point, or from one for all."""
    outward = points - away_from
    outward = outward / np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
    places = points + reach * outward + (0.0, 0.35 * FONT)
    return "".join(words(text, x, y, anchor="middle") for text, (x, y) in zip(texts, places, strict=True))


def apart(points: Points, distance: float) -> list[int]:
    """Which of the points, in their order, lie at least so far from the one chosen before."""
    kept = [0]
    for i in range(1, len(points)):
        if np.linalg.norm(points[i] - points[kept[-1]]) >= distance:
            kept.append(i)
    return kept


def ellipse(centre: Float[np.ndarray, "2"], covariance: Float[np.ndarray, "2 2"], scale: float) -> Points:
    """The 2σ ellipse around a point of the picture as a polyline, `scale` pixels for each unit of the data."""
    around = np.linspace(0.0, 2 * np.pi, 41)
    values, vectors = np.linalg.eigh(covariance)
    radii = SIGMAS * np.sqrt(np.maximum(values, 0.0))
    rim = np.stack([np.cos(around), np.sin(around)], axis=-1) * radii @ vectors.T
    return centre + scale * rim * (1.0, -1.0)


def scale_bar(axes: Axes) -> str:
    """A length of 1, 2 or 5 · 10ⁿ metres in the lower left corner."""
    longest = 0.3 * WIDTH / axes.scale
    unit = 10.0 ** np.floor(np.log10(longest))
    metres = max(step * unit for step in (1.0, 2.0, 5.0) if step * unit <= longest)
    x, y = 6.0, axes.bottom - 5.0
    line = f'<path fill="none" stroke="currentColor" d="M{x:g} {y - 4:g}v4h{metres * axes.scale:.1f}v-4"/>'
    return line + words(f"{metres:g} m", x + metres * axes.scale + 5.0, y, dim=True)


def legend(entries: Sequence[tuple[str, Colour, LineStyle]], top: float) -> str:
    """One row for each kind of line."""
    parts = []
    for row, (text, colour, style) in enumerate(entries):
        y = top + LINE * row
        parts.append(path(np.array([[6.0, y], [34.0, y]]), colour, 2.0, style))
        parts.append(words(text, 42.0, y + 3.5))
    return "".join(parts)


def _coordinates(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
