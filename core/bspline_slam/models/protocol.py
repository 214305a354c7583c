"""What an observation model decides: how map curves are made, how they take in new data, what an observation says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.association import Association, AssociationConfig, Explanation, Piece, Verdict
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.relation import Relation
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import MapSpline


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """One segment of a key scan in front of the map: its points and the sensor in the world, the splines near it."""

    scan: int
    segment: ScanSegment
    points: Float[np.ndarray, "m 2"]
    sensor: Float[np.ndarray, "2"]
    seen: Explanation


@dataclass(frozen=True, eq=False, slots=True)
class SeenBeams:
    """The beams of some associations that count, one after another, all in the robot frame.

    Association p has the beams cuts[p] … cuts[p + 1] − 1, and its sensor sits at sensors[p]. Of each beam its end, the
    first of the basis functions that live at its foot, the values of these (zeros where the curve has fewer), the
    normal of the curve there, the projection n·p of the end on it, and its weight 1/σ.
    """

    cuts: Int[np.ndarray, "p1"]
    sensors: Float[np.ndarray, "p 2"]
    points: Float[np.ndarray, "m 2"]
    first: Int[np.ndarray, "m"]
    basis: Float[np.ndarray, "m k"]
    normals: Float[np.ndarray, "m 2"]
    right: Float[np.ndarray, "m"]
    weight: Float[np.ndarray, "m"]


@runtime_checkable
class GrowingMap(Protocol):
    """The map under construction, as a model sees it while it takes in a segment."""

    @property
    def config(self) -> AssociationConfig: ...

    def spline(self, spline: int) -> MapSpline:
        """The spline under which this id lives now."""
        ...

    def carries_on(self, spline: int, points: Float[np.ndarray, "m 2"], *, forward: bool) -> bool:
        """Whether points lie beyond the end (or start) of a spline, near it, and in its direction."""
        ...

    def grow(
        self, spline: int, curve: BSpline, span: tuple[float, float], points: Float[np.ndarray, "m 2"], scan: int
    ) -> bool:
        """Give a spline a longer curve, unless it is none or these points lie too far from it."""
        ...

    def start(self, sight: Sight, piece: Piece) -> Association:
        """Start a spline from beams that none explains, or leave them out when they are too few."""
        ...

    def association(self, sight: Sight, piece: Piece, verdict: Verdict, relation: Relation | None) -> Association:
        """The record of a decision."""
        ...


@runtime_checkable
class Model(Protocol):
    """An observation model; parameters of all its curves are about metres along them."""

    @property
    def fitting(self) -> FittingConfig:
        """Degree of the curves and noise of the laser."""
        ...

    @property
    def measures_along(self) -> bool:
        """Whether observations say where control points lie along their curve; a gauge holds them there if not."""
        ...

    def with_noise(self, range_noise: float, bearing_noise: float) -> Model:
        """The model of a laser with this noise (m, rad), unless its noise is given once and for all."""
        ...

    def through(self, points: Float[np.ndarray, "m 2"]) -> BSpline:
        """A new map curve through ordered points, its domain from 0 to their chord length or a little farther."""
        ...

    def plainest(self, points: Float[np.ndarray, "m 2"], tolerance: float) -> BSpline:
        """The curve with the fewest control points that stays within `tolerance` of every point (m)."""
        ...

    def cut(self, curve: BSpline, span: tuple[float, float]) -> BSpline:
        """The curve on a stretch alone, parameters kept."""
        ...

    def take_in(self, growing: GrowingMap, sight: Sight, pieces: Sequence[Piece]) -> list[Association]:
        """Decide about the pieces of a segment, in order, and let the map grow by them."""
        ...

    def observe(self, curves: Sequence[BSpline], poses: Float[np.ndarray, "p 3"], beams: SeenBeams) -> FlatFactors:
        """What the beams of each association say about the control points of its curve, seen from its pose: factors in
        the order of the associations, on the control points of their own curves and with the number of the association
        for that of the pose. Of an association that says nothing there is none."""
        ...
