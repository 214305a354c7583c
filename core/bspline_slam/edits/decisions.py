"""Every decision behind a map, as hand edits find it and leave it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association
from bspline_slam.edits.edit import OnPiece, Triple
from bspline_slam.errors import EditError
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.graph import PoseFactor
from bspline_slam.segmentation import ScanSegment
from bspline_slam.sights import KeyObservations
from bspline_slam.slam import Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap


@dataclass(frozen=True, eq=False, slots=True)
class Decisions:
    """Key poses, what each key scan saw of which spline, and what ties poses to each other.

    `pose_pins` hold poses (by their number among the key scans) and `spline_pins` the control points of splines.
    `touched` are splines that lost or gained beams by hand, `reshaped` those whose curve an edit drew anew.
    """

    poses: Float[np.ndarray, "n 3"]
    keys: tuple[KeyObservations, ...]
    splines: SplineMap
    factors: tuple[PoseFactor, ...]
    closures: tuple[LoopClosure, ...]
    pose_pins: Mapping[int, Triple] = field(default_factory=dict)
    spline_pins: Mapping[int, Float[np.ndarray, "_ 2"]] = field(default_factory=dict)
    touched: frozenset[int] = frozenset()
    reshaped: frozenset[int] = frozenset()

    @classmethod
    def of(cls, snapshot: Snapshot) -> Decisions:
        """Those of a finished result."""
        poses = np.array([step.pose for step in snapshot.steps]).reshape(-1, 3)
        return cls(poses, snapshot.observations, snapshot.map, snapshot.pose_factors, snapshot.loop_closures)

    # -- looking up ----------------------------------------------------------------------------------------------
    def number(self, scan: int) -> int:
        """The number of a scan among the key scans. Raises EditError where it is none."""
        scans = np.array([key.scan for key in self.keys])
        k = int(np.searchsorted(scans, scan))
        if k == len(scans) or scans[k] != scan:
            raise EditError(f"scan {scan} is no key scan")
        return k

    def spline(self, spline: int) -> MapSpline:
        """A spline of the map. Raises EditError where it is gone."""
        if spline not in self.splines:
            raise EditError(f"spline {spline} is not in the map")
        return self.splines[spline]

    def segment(self, scan: int, segment: int) -> ScanSegment:
        """A segment of a key scan. Raises EditError where there is none."""
        for one in self.keys[self.number(scan)].segments:
            if one.index == segment:
                return one
        raise EditError(f"scan {scan} has no segment {segment}")

    def points(self, piece: OnPiece) -> Float[np.ndarray, "m 2"]:
        """The beam ends of a piece in the world. Raises EditError where it has none."""
        segment = self.segment(piece.scan, piece.segment)
        inside = (segment.beams >= piece.first) & (segment.beams <= piece.last)
        if not inside.any():
            raise EditError(f"segment {piece.segment} of scan {piece.scan} has no beam {piece.first} … {piece.last}")
        return se2.transform(self.poses[self.number(piece.scan)], segment.points[inside])

    # -- changed -------------------------------------------------------------------------------------------------
    def with_associations(self, number: int, associations: tuple[Association, ...]) -> Decisions:
        """Other associations of one key scan; splines that are given other beams by them are touched."""
        key = self.keys[number]
        ordered = tuple(sorted(associations, key=lambda a: (a.segment, a.first)))
        touched = {spline for spline, _, _ in _beams(key.associations) ^ _beams(ordered)}
        keys = (*self.keys[:number], replace(key, associations=ordered), *self.keys[number + 1 :])
        return replace(self, keys=keys, touched=self.touched | touched)

    def with_spline(self, spline: MapSpline) -> Decisions:
        """The map with this spline in the place of that of its id, or beside the others; its curve is new, and no pin
        of another holds it."""
        others = [one for one in self.splines if one.id != spline.id]
        ordered = sorted([*others, spline], key=lambda one: one.id)
        pins = {number: points for number, points in self.spline_pins.items() if number != spline.id}
        reshaped = self.reshaped | {spline.id}
        return replace(self, splines=SplineMap(tuple(ordered)), reshaped=reshaped, spline_pins=pins)

    def without_spline(self, spline: int) -> Decisions:
        """The map without this spline."""
        return replace(self, splines=SplineMap(tuple(one for one in self.splines if one.id != spline)))


def _beams(associations: tuple[Association, ...]) -> set[tuple[int, int, int]]:
    """Which beams are given to which spline: spline, segment and number of each."""
    return {
        (a.spline, a.segment, beam) for a in associations if a.spline is not None for beam in range(a.first, a.last + 1)
    }
