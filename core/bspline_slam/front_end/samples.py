"""Samples of all splines of a map, so that those near a scan are found without a look at the others."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam.association import AssociationConfig, Explanation
from bspline_slam.kernels import explaining

BUCKET = 0.3
"""How near (m) a spline must come to a scan to be looked at; at least the widest gate."""


class Samples:
    """Samples by spline id, one after another in arrays with room to grow; what was replaced stays there until half of
    the room is waste."""

    def __init__(self) -> None:
        self._rows = np.zeros((1024, 5))
        self._end = 0
        self._boxes = np.full((64, 4), np.nan)
        self._first, self._last = np.zeros(64, np.int64), np.zeros(64, np.int64)

    def put(
        self,
        spline: int,
        t: Float[np.ndarray, "s"],
        points: Float[np.ndarray, "s 2"],
        normals: Float[np.ndarray, "s 2"],
    ) -> None:
        """Hold the samples of a spline, or hold them anew: parameters, points, unit normals."""
        if spline >= len(self._boxes):
            more = spline + 1
            self._boxes = np.concatenate([self._boxes, np.full((more, 4), np.nan)])
            self._first, self._last = (np.append(one, np.zeros(more, np.int64)) for one in (self._first, self._last))
        self.drop(spline)
        if self._end + len(t) > len(self._rows):
            self._make_room(len(t))
        first, last = self._end, self._end + len(t)
        rows = self._rows[first:last]
        rows[:, :2], rows[:, 2:4], rows[:, 4] = points, normals, t
        self._boxes[spline, :2], self._boxes[spline, 2:] = points.min(0) - BUCKET, points.max(0) + BUCKET
        self._first[spline], self._last[spline], self._end = first, last, last

    def drop(self, spline: int) -> None:
        """Forget a spline."""
        self._boxes[spline] = np.nan
        self._first[spline] = self._last[spline] = 0

    def near(
        self, points: Float[np.ndarray, "m 2"], normals: Float[np.ndarray, "m 2"], config: AssociationConfig
    ) -> Explanation:
        """The splines that explain each world point, nearest first."""
        (left, low), (right, high) = points.min(0), points.max(0)
        box = self._boxes.T
        close = np.flatnonzero((box[0] <= right) & (box[1] <= high) & (box[2] >= left) & (box[3] >= low))
        if len(close) == 0:
            shape = (len(points), config.candidates)
            return Explanation(np.full(shape, -1), np.zeros(shape), np.zeros(shape))
        found = explaining.near_splines(
            points, normals, close, self._first[close], self._last[close], self._rows, BUCKET, config.gate,
            config.along, config.agreement, config.candidates,
        )  # fmt: skip
        return Explanation(*found)

    def _make_room(self, wanted: int) -> None:
        """Move what is held to the beginning of arrays that it fills by half at most."""
        held = np.flatnonzero(self._last)
        held = held[np.argsort(self._first[held])]
        kept = [self._rows[a:b] for a, b in zip(self._first[held], self._last[held], strict=True)]
        ends = np.cumsum([0, *map(len, kept)])
        rows = np.zeros((2 * (int(ends[-1]) + wanted), 5))
        rows[: ends[-1]] = np.concatenate([np.zeros((0, 5)), *kept])
        self._rows, self._end = rows, int(ends[-1])
        self._first[held], self._last[held] = ends[:-1], ends[1:]
