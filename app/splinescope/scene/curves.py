"""Curves as polylines, just as fine as the eye needs, many at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.bspline import BSpline
from splinescope.scene.detail import Detail
from splinescope.scene.paths import needed

FINEST = 24  # pieces that one polynomial is ever cut into

Span = tuple[float, float]


@dataclass(frozen=True, eq=False, slots=True)
class Pieces:
    """The polynomial pieces of many curves of one degree p, in order: where each begins and ends, and what shapes it.

    `knots` are the 2p knots around the piece, `control_points` its p + 1, `curve` the index of its curve.
    """

    degree: int
    start: Float[np.ndarray, "s"]
    end: Float[np.ndarray, "s"]
    knots: Float[np.ndarray, "s 2p"]
    control_points: Float[np.ndarray, "s k 2"]
    curve: Int[np.ndarray, "s"]

    @classmethod
    def of(cls, curves: Sequence[BSpline], spans: Sequence[Span], indices: Sequence[int]) -> Pieces:
        """The pieces of curves of the same degree, each within its span."""
        degree = curves[0].degree
        parts = [_pieces(curve, span) for curve, span in zip(curves, spans, strict=True)]
        start, end, knots, control_points = (np.concatenate(column) for column in zip(*parts, strict=True))
        return cls(degree, start, end, knots, control_points, np.repeat(indices, [len(part[0]) for part in parts]))

    def at(self, piece: Int[np.ndarray, "m"], fraction: Float[np.ndarray, "m"]) -> Float[np.ndarray, "m 2"]:
        """Points at a fraction (0…1) of pieces (de Boor)."""
        t = self.start[piece] + fraction * (self.end[piece] - self.start[piece])
        knots = self.knots[piece]
        points = self.control_points[piece].copy()
        for level in range(1, self.degree + 1):
            for j in range(self.degree, level - 1, -1):
                low, high = knots[:, j - 1], knots[:, j - level + self.degree]
                share = ((t - low) / (high - low))[:, None]
                points[:, j] = (1.0 - share) * points[:, j - 1] + share * points[:, j]
        return points[:, self.degree]

    def bulge(self) -> Float[np.ndarray, "s"]:
        """How far each piece may leave the chord between its ends (m); n equal parts leave theirs by n² times less.

        It is an eighth of the largest second derivative, from second differences, which for a cubic is exact.
        """
        count = len(self.start)
        piece = np.repeat(np.arange(count), 5)
        points = self.at(piece, np.tile(np.linspace(0.0, 1.0, 5), count)).reshape(count, 5, 2)
        second = 16.0 * np.diff(points, 2, axis=1)
        ends = [2.0 * second[:, 0] - second[:, 1], 2.0 * second[:, 2] - second[:, 1]]
        return np.linalg.norm(np.concatenate([second, np.stack(ends, axis=1)], axis=1), axis=-1).max(axis=1) / 8.0


@lru_cache(maxsize=8192)
def _pieces(curve: BSpline, span: Span) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    degree, knots = curve.degree, curve.knots
    index = np.arange(degree, len(curve.control_points))
    start, end = np.maximum(knots[index], span[0]), np.minimum(knots[index + 1], span[1])
    real = end > start
    index = index[real, None]
    around = knots[index + np.arange(1 - degree, degree + 1)]
    return start[real], end[real], around, curve.control_points[index + np.arange(-degree, 1)]


def sampled(
    curves: Sequence[BSpline], spans: Sequence[Span], detail: Detail, tolerance: float = 0.4
) -> tuple[Float[np.ndarray, "m 2 2"], Int[np.ndarray, "m"]]:
    """Line segments that follow the curves to twice `tolerance` pixels, and the index of the curve of each.

    Outside of the detail's window one point per polynomial has to do.
    """
    vertices, owners = [np.zeros((0, 2))], [np.zeros(0, dtype=int)]
    for degree in sorted({curve.degree for curve in curves}):
        chosen = [i for i, curve in enumerate(curves) if curve.degree == degree]
        pieces = Pieces.of([curves[i] for i in chosen], [spans[i] for i in chosen], chosen)
        if len(pieces.start):
            points, owner = _vertices(pieces, detail, tolerance * detail.pixel)
            vertices.append(points)
            owners.append(owner)
    points, owner = np.concatenate(vertices), np.concatenate(owners)
    changes = owner[1:] != owner[:-1]
    kept = needed(points, np.append(True, changes) | np.append(changes, True), tolerance * detail.pixel)
    points, owner = points[kept], owner[kept]
    whole = owner[1:] == owner[:-1]
    return np.stack([points[:-1][whole], points[1:][whole]], axis=1), owner[:-1][whole]


def _vertices(
    pieces: Pieces, detail: Detail, tolerance: float
) -> tuple[Float[np.ndarray, "v 2"], Int[np.ndarray, "v"]]:
    """Points along the curves, whose chords stay within `tolerance` (m) of them, and the curve of each."""
    fineness = np.ceil(np.sqrt(pieces.bulge() / tolerance))
    near = detail.inside(pieces.control_points[:, 0]) | detail.inside(pieces.control_points[:, -1])
    count = np.where(near, np.clip(fineness, 1, FINEST), 1).astype(int)
    last = np.append(pieces.curve[1:] != pieces.curve[:-1], True)
    count_with_end = count + last
    piece = np.repeat(np.arange(len(count)), count_with_end)
    step = np.arange(len(piece)) - np.repeat(np.cumsum(count_with_end) - count_with_end, count_with_end)
    return pieces.at(piece, step / count[piece]), pieces.curve[piece]
