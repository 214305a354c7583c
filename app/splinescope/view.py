"""What the page shows at one moment, as values: the session makes a View, the scene draws it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association
from bspline_slam.bspline import BSpline
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.lab.stretches import Stretches
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import SplineMap


class Layer(Enum):
    """Everything that can be switched; the value is its label in the page."""

    BEAMS = "Beams"
    NO_RETURN = "No-return beams"
    SEGMENTS = "Segments"
    FITS = "Fitted curves"
    FIT_POINTS = "Control points of the fit"
    FIT_ELLIPSES = "2σ ellipses of the fit (86 %)"
    BREAKS = "Breakpoints and corners"
    ASSOCIATIONS = "Associations"
    SPLINES = "Map splines"
    COMPARED = "Compared result"
    CONTROL_POINTS = "Map control points"
    ELLIPSES = "2σ ellipses of the map (86 %)"
    ESTIMATE = "Trajectory (estimate)"
    ODOMETRY = "Trajectory (odometry)"
    TRUTH = "Trajectory (truth)"
    LOOPS = "Loop closures"
    GRID = "Grid"


class Colouring(Enum):
    """What the curves of the map are coloured by; the value is its label in the page."""

    SPLINE = "spline, each its own"
    RESIDUAL = "residual"
    UNCERTAINTY = "uncertainty"
    OBSERVATIONS = "observations"
    AGE = "age"


@dataclass(frozen=True, eq=False, slots=True)
class FittedSegment:
    """A segment with the curve fitted to it: robot frame, covariance of the stacked control points (c_1x, c_1y,
    …)."""

    segment: ScanSegment
    curve: BSpline | None
    covariance: Float[np.ndarray, "d d"] | None


@dataclass(frozen=True, eq=False, slots=True)
class ScanView:
    """The scan under the cursor, placed in the world by `pose`."""

    scan: LaserScan
    pose: Float[np.ndarray, "3"]
    key: bool
    lost: bool
    segments: tuple[FittedSegment, ...]
    associations: tuple[Association, ...]


@dataclass(frozen=True, eq=False, slots=True)
class MapView:
    """The map and the paths; a new object whenever anything in it changed, the same object otherwise.

    Paths are (m, 3) poses in the world frame, None where the log has none; odometry and truth come already aligned
    to the start of the estimate. `stretches` tell the residuals along the curves and `sigmas` 1σ across them, once they
    are measured. `times` are those of all scans of the log (s).
    """

    map: SplineMap
    covariances: Mapping[int, Float[np.ndarray, "d d"]]
    key_poses: Float[np.ndarray, "n 3"]
    key_scans: tuple[int, ...]
    loop_closures: tuple[LoopClosure, ...]
    estimate: Float[np.ndarray, "m 3"]
    odometry: Float[np.ndarray, "m 3"] | None
    truth: Float[np.ndarray, "m 3"] | None
    stretches: Stretches | None = None
    sigmas: Stretches | None = None
    times: Float[np.ndarray, "scans"] | None = None


Point = tuple[float, float]
"""A place in the world (m)."""
Piece = tuple[int, int, int]
"""A piece of a scan: its segment, its first and its last beam."""


@dataclass(frozen=True, slots=True)
class Selection:
    """What was clicked: `kind` is "segment" (id: segment index of the current scan), "spline" (id: spline id),
    "control point"
    (id: spline id, sub: number of the control point), "key pose" (id: scan index), "closure" (id: its number) or
    "pieces" (id: index of the key scan that the several `pieces` are of)."""

    kind: str
    id: int
    sub: int = 0
    pieces: tuple[Piece, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class GhostView:
    """What hand edits would change, drawn over the map: splines and path as they would be, the beam ends of a scan that
    is laid over another, points clicked for that, lines that show where the last edits moved key poses, the places
    that are pinned, and the two ends of each loop closure made by hand."""

    splines: SplineMap | None = None
    path: Float[np.ndarray, "m 3"] | None = None
    points: Float[np.ndarray, "k 2"] | None = None
    marks: tuple[Point, ...] = ()
    moves: Float[np.ndarray, "n 2 2"] | None = None
    pins: tuple[Point, ...] = ()
    ties: tuple[tuple[Point, Point], ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """One frame of the page; `measured` are the places that the ruler lies on (m), `asks` is a sentence that a person
    is to read now."""

    map: MapView | None = None
    scan: ScanView | None = None
    layers: frozenset[Layer] = field(default_factory=frozenset)
    selection: Selection | None = None
    dark: bool = True
    compared: MapView | None = None
    colouring: Colouring = Colouring.SPLINE
    measured: Float[np.ndarray, "k 2"] | None = None
    ghost: GhostView | None = None
    asks: str = ""

    @property
    def comparing(self) -> bool:
        """Whether a second result is drawn over the map."""
        return self.compared is not None and Layer.COMPARED in self.layers
