"""Beams in front of the map: which beam of which key scan an association gives to which spline, and its foot there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.association import Association
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


@dataclass(frozen=True, eq=False, slots=True)
class Sights:
    """Every beam that an association gives to a spline, sorted by spline and then by piece.

    `pose` and `spline` are positions among the key scans and in the map; `piece` numbers the associations. Points,
    directions (robot frame) and ranges are per beam.
    """

    spline: Int[np.ndarray, "m"]
    pose: Int[np.ndarray, "m"]
    piece: Int[np.ndarray, "m"]
    points: Float[np.ndarray, "m 2"]
    directions: Float[np.ndarray, "m 2"]
    ranges: Float[np.ndarray, "m"]


def collect_sights(keys: Sequence[KeyObservations], splines: SplineMap) -> Sights:
    """The beams of all associations whose spline is in the map."""
    place = {spline.id: k for k, spline in enumerate(splines)}
    rows: list[tuple[int, int, Float[np.ndarray, "m 2"], Float[np.ndarray, "2"]]] = []
    for pose, key in enumerate(keys):
        by_index = {segment.index: segment for segment in key.segments}
        for association in key.associations:
            if association.spline is None or association.spline not in place:
                continue
            segment = by_index[association.segment]
            inside = (segment.beams >= association.first) & (segment.beams <= association.last)
            rows.append((place[association.spline], pose, segment.points[inside], key.sensor))
    rows.sort(key=lambda row: row[0])
    if not rows:
        empty = np.zeros(0, dtype=np.int64)
        return Sights(empty, empty, empty, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    counts = [len(points) for _, _, points, _ in rows]
    points = np.concatenate([points for _, _, points, _ in rows])
    rays = points - np.repeat(np.array([sensor for *_, sensor in rows]), counts, axis=0)
    ranges = np.linalg.norm(rays, axis=1)
    return Sights(
        np.repeat([spline for spline, *_ in rows], counts),
        np.repeat([pose for _, pose, *_ in rows], counts),
        np.repeat(np.arange(len(rows)), counts),
        points,
        rays / np.maximum(ranges, 1e-9)[:, None],
        ranges,
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


def find_feet(
    sights: Sights, splines: SplineMap, poses: Float[np.ndarray, "n 3"], gate: float | Float[np.ndarray, "m"]
) -> Feet:
    """Foot points of all beams on their splines; a beam counts when it lies within the gate (of all, or its own),
    inside the supported stretch, and in front of the curve."""
    m = len(sights.points)
    degree = splines.splines[0].curve.degree if len(splines) else 3
    t, across = np.zeros(m), np.zeros(m)
    first, basis, normals = np.zeros(m, np.int64), np.zeros((m, degree + 1)), np.zeros((m, 2))
    beyond = np.zeros(m)
    world = se2.transform(poses[sights.pose], sights.points)
    cuts = np.searchsorted(sights.spline, np.arange(len(splines) + 1))
    for k, spline in enumerate(splines):
        a, b = cuts[k], cuts[k + 1]
        if a == b:
            continue
        curve, (low, high) = spline.curve, spline.span
        sample_t, samples = curve.sample(0.1, spline.span)
        t[a:b], first[a:b], basis[a:b], normals[a:b] = kernels.feet(
            curve.knots, degree, curve.control_points, sample_t, samples, world[a:b], low, high
        )
        index = first[a:b, None] + np.arange(degree + 1)
        off = world[a:b] - np.einsum("mk,mkd->md", basis[a:b], curve.control_points[index])
        across[a:b] = (off * normals[a:b]).sum(1)
        beyond[a:b] = np.abs(off[:, 0] * normals[a:b, 1] - off[:, 1] * normals[a:b, 0])
    towards = se2.rotate(poses[sights.pose], -sights.directions)
    facing = (towards * normals).sum(1) > 0.05
    return Feet(t, first, basis, normals, across, (np.abs(across) < gate) & (beyond < 0.05) & facing)
