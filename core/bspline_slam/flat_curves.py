"""Many curves as flat arrays, in the order that compiled kernels read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.bspline import BSpline
from bspline_slam.kernels import curves as kernels


@dataclass(frozen=True, eq=False, slots=True)
class FlatCurves:
    """Curve c has the knots knot_start[c] … knot_start[c + 1] − 1 and the control points from point_start[c] on."""

    degrees: Int[np.ndarray, "c"]
    knot_start: Int[np.ndarray, "c1"]
    knots: Float[np.ndarray, "k"]
    point_start: Int[np.ndarray, "c1"]
    control_points: Float[np.ndarray, "n 2"]

    @classmethod
    def of(cls, curves: Sequence[BSpline]) -> FlatCurves:
        """These curves, one after another."""
        degrees = np.array([curve.degree for curve in curves], dtype=np.int64)
        counts = np.array([len(curve.control_points) for curve in curves], dtype=np.int64)
        return cls(
            degrees,
            _starts(counts + degrees + 1),
            np.concatenate([np.zeros(0), *(curve.knots for curve in curves)]),
            _starts(counts),
            np.concatenate([np.zeros((0, 2)), *(curve.control_points for curve in curves)]),
        )

    @property
    def order(self) -> int:
        """The most basis functions that live at one parameter of any curve."""
        return int(self.degrees.max(initial=1)) + 1

    def greville(self) -> tuple[Float[np.ndarray, "n"], Float[np.ndarray, "n 2"]]:
        """Of each control point its Greville abscissa, and the unit tangent of its curve there."""
        return kernels.greville(self.degrees, self.knot_start, self.knots, self.point_start, self.control_points)

    def points_at(self, t: Float[np.ndarray, "c"]) -> Float[np.ndarray, "c 2"]:
        """The point of each curve at its parameter."""
        return kernels.points_at(t, self.degrees, self.knot_start, self.knots, self.point_start, self.control_points)


def _starts(counts: Int[np.ndarray, "c"]) -> Int[np.ndarray, "c1"]:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
