"""Beams in front of the map: which beam of which key scan an association gives to which spline, and its foot there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.association import Association
from bspline_slam.flat_curves import FlatCurves
from bspline_slam.halves import in_halves
from bspline_slam.kernels import curves as kernels
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import SplineMap


@dataclass(frozen=True, eq=False, slots=True)
class KeyObservations:
    """One key scan as adjustment sees it: its segments, its decisions, how many beams came back, where the sensor
    sits."""

    scan: int
    segments: tuple[ScanSegment, ...]
    associations: tuple[Association, ...]
    beams: int
    sensor: Float[np.ndarray, "2"]

    def beams_of(self, association: Association) -> Int[np.ndarray, "m"]:
        """The beams that an association of this key scan is about."""
        segment = next(segment for segment in self.segments if segment.index == association.segment)
        return segment.beams[(segment.beams >= association.first) & (segment.beams <= association.last)]


@dataclass(frozen=True, eq=False, slots=True)
class Sights:
    """Every beam that an association gives to a spline, sorted by spline and then by piece.

    `pose` and `spline` are positions among the key scans and in the map; `piece` numbers the associations and `beam` is
    the number of a beam in its scan. Points, directions (robot frame) and ranges are per beam.
    """

    spline: Int[np.ndarray, "m"]
    pose: Int[np.ndarray, "m"]
    piece: Int[np.ndarray, "m"]
    beam: Int[np.ndarray, "m"]
    points: Float[np.ndarray, "m 2"]
    directions: Float[np.ndarray, "m 2"]
    ranges: Float[np.ndarray, "m"]


def collect_sights(keys: Sequence[KeyObservations], splines: SplineMap) -> Sights:
    """The beams of all associations whose spline is in the map."""
    place = {spline.id: k for k, spline in enumerate(splines)}
    rows: list[tuple[int, int, Float[np.ndarray, "m 2"], Float[np.ndarray, "2"], Int[np.ndarray, "m"]]] = []
    for pose, key in enumerate(keys):
        by_index = {segment.index: segment for segment in key.segments}
        for association in key.associations:
            if association.spline is None or (spline := place.get(association.spline)) is None:
                continue
            segment = by_index[association.segment]
            beams, points = segment.beams, segment.points
            if len(beams) and (beams[0] < association.first or beams[-1] > association.last):
                inside = slice(beams.searchsorted(association.first), beams.searchsorted(association.last + 1))
                beams, points = beams[inside], points[inside]
            rows.append((spline, pose, points, key.sensor, beams))
    rows.sort(key=lambda row: row[0])
    if not rows:
        empty = np.zeros(0, dtype=np.int64)
        return Sights(empty, empty, empty, empty, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    counts = [len(points) for _, _, points, *_ in rows]
    points = np.concatenate([points for _, _, points, *_ in rows])
    rays = points - np.repeat(np.array([sensor for *_, sensor, _ in rows]), counts, axis=0)
    ranges = np.linalg.norm(rays, axis=1)
    return Sights(
        np.repeat([spline for spline, *_ in rows], counts),
        np.repeat([pose for _, pose, *_ in rows], counts),
        np.repeat(np.arange(len(rows)), counts),
        np.concatenate([beams for *_, beams in rows]),
        points,
        rays / np.maximum(ranges, 1e-9)[:, None],
        ranges,
    )


def pieces_of(keys: Sequence[KeyObservations], splines: SplineMap) -> list[tuple[int, int, int]]:
    """Of each piece of `collect_sights`: the place of its spline in the map, the position of its key scan, and the
    number of its association there."""
    place = {spline.id: k for k, spline in enumerate(splines)}
    return sorted(
        (place[association.spline], pose, number)
        for pose, key in enumerate(keys)
        for number, association in enumerate(key.associations)
        if association.spline is not None and association.spline in place
    )


def renumbered(sights: Sights, before: SplineMap, after: SplineMap) -> Sights:
    """The same in a map that some splines have left; their beams are gone too."""
    place = {spline.id: k for k, spline in enumerate(after)}
    moved = np.array([place.get(spline.id, -1) for spline in before], dtype=np.int64)[sights.spline]
    kept = moved >= 0
    return Sights(
        moved[kept],
        sights.pose[kept],
        sights.piece[kept],
        sights.beam[kept],
        sights.points[kept],
        sights.directions[kept],
        sights.ranges[kept],
    )


@dataclass(frozen=True, eq=False, slots=True)
class Feet:
    """For each beam its foot on its spline: parameter, basis, curve normal (world), distance across, and whether
    it counts."""

    t: Float[np.ndarray, "m"]
    first: Int[np.ndarray, "m"]
    basis: Float[np.ndarray, "m k"]
    normals: Float[np.ndarray, "m 2"]
    across: Float[np.ndarray, "m"]
    counts: Bool[np.ndarray, "m"]


START_SPACING = 0.1
"""Distance of parameter (m) between the samples of a curve among which the search for feet begins."""
BESIDE, FACING = 0.05, 0.05
"""How far (m) beside its foot a beam may end, at an end of its curve, and the least cosine between the normal of a
curve and the way back to the sensor."""


def find_feet(
    sights: Sights,
    splines: SplineMap,
    poses: Float[np.ndarray, "n 3"],
    gate: float | Float[np.ndarray, "m"],
    beyond: float = 0.0,
) -> Feet:
    """Foot points of all beams on their splines; a beam counts when it lies within the gate (of all, or its own),
    inside the supported stretch, and in front of the curve. Feet may lie `beyond` the ends of that stretch (m)."""
    curves, n = FlatCurves.of([spline.curve for spline in splines]), len(sights.pose)
    t, across, beside, facing = np.zeros((4, n))
    first, basis, normals = np.zeros(n, dtype=np.int64), np.zeros((n, curves.order)), np.zeros((n, 2))
    spans = np.array([(s.span[0] - beyond, s.span[1] + beyond) for s in splines], dtype=float).reshape(-1, 2)
    cuts = np.searchsorted(sights.spline, np.arange(len(splines) + 1))
    frames = np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])

    def find(c_first: int, c_last: int) -> None:
        kernels.feet(
            c_first, c_last, curves.degrees, curves.knot_start, curves.knots, curves.point_start, curves.control_points,
            spans, cuts, frames, sights.pose, sights.points, sights.directions, START_SPACING,
            t, first, basis, normals, across, beside, facing,
        )  # fmt: skip

    in_halves(find, cuts)
    counts = (np.abs(across) < gate) & (beside < BESIDE) & (facing > FACING)
    return Feet(t, first, basis, normals, across, counts)
