"""A scan cut into segments: breakpoints, corners, and what kind of end each piece has."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.kernels import surfaces
from bspline_slam.scan import LaserScan


class EndKind(Enum):
    """Why a segment ends."""

    EDGE = "edge"  # the nearer side of a range jump: the thing itself ends here
    OCCLUDED = "occluded"  # the farther side: only its visibility ends here
    CORNER = "corner"  # the next segment goes on from here in another direction
    NO_RETURN = "no return"  # the next beam came back from nowhere
    FIELD_OF_VIEW = "field of view"  # the scan ends here


@dataclass(frozen=True, eq=False, slots=True)
class ScanSegment:
    """A run of neighbouring beams that saw one smooth piece of the world.

    `index` counts the segments of the scan; `beams` are beam numbers (increasing, invalid beams left out);
    `points` are their ends in the robot frame, so the robot is on the left of them as they run.
    """

    scan: int
    index: int
    beams: Int[np.ndarray, "m"]
    points: Float[np.ndarray, "m 2"]
    start: EndKind
    end: EndKind


@dataclass(frozen=True, slots=True)
class SegmentationConfig:
    """Thresholds of the segmentation (m, rad).

    `incidence` is λ of the adaptive breakpoint detector (Borges & Aldon 2004): the flattest wall that is still
    followed. `corner` is the turn that ends a segment, measured between chords of `corner_reach` on both sides. A beam
    beside a range jump that ends more than `mixed` off the line of its neighbours has lit both surfaces and tells of
    neither (a mixed pixel; Tuley et al. 2005).
    """

    incidence: float = np.deg2rad(10.0)
    slack: float = 0.05
    leap: float = 0.15
    leap_ratio: float = 2.5
    range_noise: float = 0.012
    corner: float = np.deg2rad(40.0)
    corner_reach: float = 0.15
    least_points: int = 4
    bridged_beams: int = 2
    largest_range: float = 60.0
    mixed: float = 0.02


BESIDE = 4
"""So many neighbours tell the line that a beam beside a range jump should end on."""


def segment_scan(scan: LaserScan, config: SegmentationConfig = SegmentationConfig()) -> tuple[ScanSegment, ...]:
    """Cut a scan at range jumps and at corners, mixed pixels left out; pieces of fewer than `least_points` beams are
    left out, too."""
    beams = np.flatnonzero(scan.valid & (scan.ranges < config.largest_range))
    if len(beams) < config.least_points:
        return ()
    points = scan.points_robot[beams]
    jumps = breakpoints(scan.ranges[beams], scan.bearings[beams], scan.resolution, config)
    corners = corner_points(points, jumps, config)
    cuts = np.concatenate([[0], np.flatnonzero(jumps | corners) + 1, [len(beams)]])
    breaks = np.concatenate([[False], jumps[cuts[1:-1] - 1], [False]])
    mixed = surfaces.mixed_ends(points, cuts, breaks, config.mixed, BESIDE, config.least_points)
    kinds, segments = _end_kinds(scan, beams, corners, cuts), []
    for (a, b), (start, end), (before, behind) in zip(
        itertools.pairwise(cuts.tolist()), kinds, mixed.tolist(), strict=True
    ):
        if b - a >= config.least_points:
            sound = slice(a + before, b - behind)
            segments.append(ScanSegment(scan.index, len(segments), beams[sound], points[sound], start, end))
    return tuple(segments)


def breakpoints(
    ranges: Float[np.ndarray, "m"], bearings: Float[np.ndarray, "m"], resolution: float, config: SegmentationConfig
) -> Bool[np.ndarray, "m-1"]:
    """Whether the surface breaks between beams j and j+1 (Borges & Aldon 2004, eq. 8, with slack), or leaps: a gap of
    more than `leap` and `leap_ratio` times those beside it."""
    return surfaces.breakpoints(ranges, bearings, *break_limits(resolution, config))


def break_limits(resolution: float, config: SegmentationConfig) -> tuple[float, float, float, float, float]:
    """What `kernels.surfaces.breakpoints` asks for: flattest incidence (rad), allowance, leap (m), ratio of a leap to
    the gaps beside it, and the widest angle between beams (rad)."""
    allowance, widest = 3 * config.range_noise + config.slack, (config.bridged_beams + 1.5) * resolution
    return config.incidence, allowance, config.leap, config.leap_ratio, widest


def corner_points(
    points: Float[np.ndarray, "m 2"], jumps: Bool[np.ndarray, "m-1"], config: SegmentationConfig
) -> Bool[np.ndarray, "m-1"]:
    """Whether a segment ends after point j because the outline turns there by more than `corner`.

    The turn at j is taken between the chords to the points at least `corner_reach` (and two beams) before and after
    it in the same run; only the sharpest point of each neighbourhood cuts.
    """
    m = len(points)
    run = np.concatenate([[0], np.cumsum(jumps)])
    before, after = _reach_indices(points, run, config.corner_reach)
    inside = (before >= 0) & (after >= 0)
    u = points - points[np.maximum(before, 0)]
    v = points[np.maximum(after, 0)] - points
    turn = np.abs(np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(1)))
    turn[~inside] = 0.0
    out = np.zeros(m - 1, dtype=bool)
    for j in np.flatnonzero(turn > config.corner):
        if turn[j] >= turn[before[j] : after[j] + 1].max() and j < m - 1 and not out[before[j] : j].any():
            out[j] = True
    return out


def _reach_indices(
    points: Float[np.ndarray, "m 2"], run: Int[np.ndarray, "m"], reach: float
) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"]]:
    """For each point the nearest index before and after it that is `reach` away and two beams off; −1 if none."""
    step = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1)])
    length = np.cumsum(step)
    index = np.arange(len(points))
    before = np.minimum(np.searchsorted(length, length - reach, side="right") - 1, index - 2)
    after = np.maximum(np.searchsorted(length, length + reach, side="left"), index + 2)
    before = np.where((before >= 0) & (run[np.maximum(before, 0)] == run), before, -1)
    last = len(points) - 1
    after = np.where((after <= last) & (run[np.minimum(after, last)] == run), after, -1)
    return before, after


def _end_kinds(
    scan: LaserScan, beams: Int[np.ndarray, "m"], corners: Bool[np.ndarray, "m-1"], cuts: Int[np.ndarray, "k1"]
) -> list[tuple[EndKind, EndKind]]:
    """Why each of the pieces between these cuts of the kept beams starts and ends."""
    starts, ends = [EndKind.NO_RETURN if beams[0] > 0 else EndKind.FIELD_OF_VIEW], []
    inner = cuts[1:-1]
    here, before = beams[inner], beams[inner - 1]
    ranges = zip(scan.ranges[before].tolist(), scan.ranges[here].tolist(), strict=True)
    missing = (here - before > 1).tolist()
    for corner, gap, (near, far) in zip(corners[inner - 1].tolist(), missing, ranges, strict=True):
        if corner or gap:
            ends.append(EndKind.CORNER if corner else EndKind.NO_RETURN)
            starts.append(ends[-1])
        else:
            ends.append(EndKind.EDGE if near < far else EndKind.OCCLUDED)
            starts.append(EndKind.EDGE if far < near else EndKind.OCCLUDED)
    ends.append(EndKind.NO_RETURN if beams[-1] + 1 < len(scan.ranges) else EndKind.FIELD_OF_VIEW)
    return list(zip(starts, ends, strict=True))
