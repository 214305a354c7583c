"""The map: splines with ids that last, each with the stretch of curve that scans support."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline


@dataclass(frozen=True, eq=False, slots=True)
class MapSpline:
    """One landmark: a curve in the world frame.

    `span` is the stretch of parameters that scans support (the curve is not drawn or matched beyond it).
    `born` is the index of the scan that started it, `observations` how many key scans saw it, and `history`
    one sentence per thing that happened to it (`grew by 0.8 m at scan 120`).

    `left_out` is the variance (m²) of the wall about the curve by small waves that no knot was spent on
    (`bspline_slam.adjustment.knots.left_out`). Covariances of control points are those of the curve and tell nothing of
    it; a place on the wall has it beside them, independent of other places more than a knot away.
    """

    id: int
    curve: BSpline
    span: tuple[float, float]
    born: int
    observations: int = 1
    history: tuple[str, ...] = ()
    left_out: float = 0.0

    def sample(self, spacing: float) -> tuple[Float[np.ndarray, "s"], Float[np.ndarray, "s 2"]]:
        """Parameters and world points of the supported stretch, about `spacing` metres apart."""
        return self.curve.sample(spacing, self.span)

    def moved(self, motion: Float[np.ndarray, "3"]) -> MapSpline:
        """The spline moved as a whole (world frame)."""
        return replace(self, curve=self.curve.moved(motion))

    @property
    def length(self) -> float:
        """Length of the supported stretch (m)."""
        return self.curve.length(self.span)


@dataclass(frozen=True, eq=False, slots=True)
class SplineMap:
    """All splines, by id in increasing order."""

    splines: tuple[MapSpline, ...] = ()

    def __len__(self) -> int:
        return len(self.splines)

    def __iter__(self) -> Iterator[MapSpline]:
        return iter(self.splines)

    def __getitem__(self, spline_id: int) -> MapSpline:
        for spline in self.splines:
            if spline.id == spline_id:
                return spline
        raise KeyError(f"the map has no spline {spline_id}")

    def __contains__(self, spline_id: int) -> bool:
        return any(spline.id == spline_id for spline in self.splines)

    @property
    def control_point_count(self) -> int:
        return sum(len(spline.curve.control_points) for spline in self.splines)

    def seen_by_at_least(self, key_scans: int) -> SplineMap:
        """The splines that so many key scans saw."""
        return SplineMap(tuple(spline for spline in self.splines if spline.observations >= key_scans))
