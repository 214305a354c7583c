"""Rays against a whole map: short chords in the cells of a grid find which curve is met, the curve says where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.bspline import BSpline
from bspline_slam.errors import GeometryError
from bspline_slam.kernels import casting as kernels

SPACING = 0.03
"""Length of the chords (m): short enough that a ray that meets a chord meets the curve above it, and no other first."""
CELL = 0.3
NEWTON_STEPS = 5


@dataclass(frozen=True, eq=False, slots=True)
class Obstacles:
    """Curves that stop rays, cut into chords.

    Chord c runs on curve `curve[c]` from parameter `t[c, 0]` to `t[c, 1]`, its ends are `ends[c]`. The chords of a cell
    of the grid are `order[start[cell] : start[cell + 1]]`; `corner` is the lower left of the grid (m).
    """

    curves: tuple[BSpline, ...]
    curve: Int[np.ndarray, "c"]
    t: Float[np.ndarray, "c 2"]
    ends: Float[np.ndarray, "c 2 2"]
    start: Int[np.ndarray, "_"]
    order: Int[np.ndarray, "_"]
    corner: Float[np.ndarray, "2"]
    columns: int
    rows: int

    @classmethod
    def from_curves(cls, curves: Sequence[BSpline]) -> Obstacles:
        """The whole domain of each curve; raises GeometryError where there is none."""
        if not curves:
            raise GeometryError("there is no curve that could stop a ray")
        samples = [_samples(curve) for curve in curves]
        t = np.concatenate([np.stack([t[:-1], t[1:]], -1) for t, _ in samples])
        ends = np.concatenate([np.stack([points[:-1], points[1:]], 1) for _, points in samples])
        owner = np.repeat(np.arange(len(curves)), [len(t) - 1 for t, _ in samples])
        corner = ends.min((0, 1)) - CELL
        columns, rows = (int(n) for n in np.ceil((ends.max((0, 1)) + CELL - corner) / CELL))
        start, order = _by_cell(np.floor((ends - corner) / CELL).astype(np.int64), columns, rows)
        return cls(tuple(curves), owner, t, ends, start, order, corner, columns, rows)

    def hits(
        self, origins: Float[np.ndarray, "m 2"], directions: Float[np.ndarray, "m 2"], reach: float
    ) -> tuple[Float[np.ndarray, "m"], Int[np.ndarray, "m"]]:
        """Distance (m) to the first curve along each ray and the number of that curve; inf and −1 where there is none
        within `reach`. Directions are unit vectors."""
        chord, distance, share = kernels.first_chords(
            origins, directions, reach, self.ends, self.start, self.order, self.corner, self.columns, self.rows, CELL
        )
        met = np.flatnonzero(chord >= 0)
        curve = np.full(len(origins), -1)
        curve[met] = self.curve[chord[met]]
        by_curve = met[np.argsort(curve[met], kind="stable")]
        cuts = np.flatnonzero(np.diff(curve[by_curve])) + 1
        for rays in np.split(by_curve, cuts) if len(by_curve) else ():
            distance[rays] = _exact(
                self.curves[curve[rays[0]]], self.t[chord[rays]], share[rays], origins[rays], directions[rays]
            )
        return distance, curve


def _samples(curve: BSpline) -> tuple[Float[np.ndarray, "s"], Float[np.ndarray, "s 2"]]:
    """Parameters and points at most SPACING apart; all knots are among them, for there a curve may have a corner."""
    inner = curve.knots[(curve.knots > curve.domain[0]) & (curve.knots < curve.domain[1])]
    t = np.union1d(curve.sample(SPACING)[0], inner)
    return t, curve(t)


def _by_cell(
    cells: Int[np.ndarray, "c 2 2"], columns: int, rows: int
) -> tuple[Int[np.ndarray, "_"], Int[np.ndarray, "_"]]:
    """Chords by the cells that their bounding boxes touch, which are at most four: chords are shorter than cells."""
    corners = np.stack([cells[:, a, 1] * columns + cells[:, b, 0] for a in (0, 1) for b in (0, 1)], -1)
    pairs = np.unique(np.stack([corners.ravel(), np.repeat(np.arange(len(cells)), 4)], -1), axis=0)
    return np.searchsorted(pairs[:, 0], np.arange(columns * rows + 1)), pairs[:, 1].copy()


def _exact(
    curve: BSpline,
    between: Float[np.ndarray, "m 2"],
    share: Float[np.ndarray, "m"],
    origins: Float[np.ndarray, "m 2"],
    directions: Float[np.ndarray, "m 2"],
) -> Float[np.ndarray, "m"]:
    """Distances at which rays cross the curve between two parameters, by Newton's method from the chord there."""
    low, high = between.T
    t = low + share * (high - low)
    for _ in range(NEWTON_STEPS):
        off, tangent = curve(t) - origins, curve(t, 1)
        slope = directions[:, 0] * tangent[:, 1] - directions[:, 1] * tangent[:, 0]
        value = directions[:, 0] * off[:, 1] - directions[:, 1] * off[:, 0]
        t = np.clip(t - value / np.where(np.abs(slope) > 1e-12, slope, np.inf), low, high)
    return ((curve(t) - origins) * directions).sum(1)
