"""Which walls meet in a corner: told by scans whose beams go on from the one to the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.adjustment.trimming import TrimmingConfig, facing_spacing
from bspline_slam.corners import LOOSE, Crossing, Joint, end_crossing
from bspline_slam.models.protocol import Model
from bspline_slam.sights import Feet, Sights
from bspline_slam.spline_map import MapSpline, SplineMap

BRIDGED = 2
"""So many beams may be missing between the last on one wall and the first on the next."""
NEAR = 3.0
"""Beams tell of the end of a wall that is no farther than this many times the widest gap."""
LEEWAY = 3.0
"""Beams lie beyond a corner if they end so many standard deviations of their range behind it."""


@dataclass(frozen=True, slots=True)
class WallsInTurn:
    """Ids of two splines of which scans saw the one end and the other begin with beams beside each other.

    `end` and `start` are the parameters at which half of these scans saw the first end by and the second begin by,
    `spacing` how far apart (m) such beams would end on a wall that faces the robot, where they do so closest.
    """

    before: int
    after: int
    end: float
    start: float
    spacing: float


def walls_in_turn(splines: SplineMap, sights: Sights, feet: Feet, config: TrimmingConfig) -> tuple[WallsInTurn, ...]:
    """All pairs of splines that enough key scans saw one after the other."""
    kept = np.flatnonzero(feet.counts)
    spacing = facing_spacing(sights, kept)
    order = np.lexsort((sights.beam[kept], sights.pose[kept]))
    kept, spacing = kept[order], spacing[order]
    rows = np.flatnonzero(_beside(sights, kept[:-1], kept[1:]))
    rows = rows[_near_ends(splines, sights, feet, kept[rows], kept[rows + 1], NEAR * config.gap)]
    a, b, apart = kept[rows], kept[rows + 1], np.maximum(spacing[rows], spacing[rows + 1])
    pairs, pair = np.unique(np.stack([sights.spline[a], sights.spline[b]], axis=1), axis=0, return_inverse=True)
    out = []
    for number, (i, j) in enumerate(pairs.tolist()):
        mine = pair == number
        if len(np.unique(sights.pose[a[mine]])) >= config.support:
            end, start = float(np.median(feet.t[a[mine]])), float(np.median(feet.t[b[mine]]))
            out.append(WallsInTurn(splines.splines[i].id, splines.splines[j].id, end, start, float(apart[mine].min())))
    return tuple(out)


def _beside(sights: Sights, a: Int[np.ndarray, "r"], b: Int[np.ndarray, "r"]) -> Bool[np.ndarray, "r"]:
    """Whether the second beam of each pair comes right after the first in its scan, on another spline."""
    step = np.where(sights.pose[a] == sights.pose[b], sights.beam[b] - sights.beam[a], 0)
    return (step > 0) & (step <= 1 + BRIDGED) & (sights.spline[a] != sights.spline[b])


def _near_ends(
    splines: SplineMap, sights: Sights, feet: Feet, a: Int[np.ndarray, "r"], b: Int[np.ndarray, "r"], reach: float
) -> Bool[np.ndarray, "r"]:
    """Whether the first beam of each pair has its foot near the end of its spline, and the second near the start."""
    spans: Float[np.ndarray, "k 2"] = np.array([spline.span for spline in splines]).reshape(-1, 2)
    return (feet.t[a] > spans[sights.spline[a], 1] - reach) & (feet.t[b] < spans[sights.spline[b], 0] + reach)


def with_corners(
    splines: SplineMap, in_turn: Sequence[WallsInTurn], config: TrimmingConfig, model: Model
) -> tuple[SplineMap, tuple[Joint, ...]]:
    """The map with walls that meet in a corner ending where they cross, and these joints.

    Of walls that were seen in turn, neither may end farther from their crossing than a gap in a wall may be wide, and
    half of the scans must have seen neither go on beyond it. What is missing up to there is drawn, what reaches beyond
    is left out. Each end of a wall is at one corner, the nearest.
    """
    by_id = {spline.id: spline for spline in splines}
    spans = {spline.id: spline.span for spline in splines}
    ended, started, leeway = set[int](), set[int](), LEEWAY * model.fitting.range_noise
    joints: list[Joint] = []
    for _, before, after, found in sorted(_crossings(by_id, in_turn, config, leeway), key=lambda one: one[:3]):
        (low, _), (_, high) = spans[before], spans[after]
        if before in ended or after in started or min(found.t - low, high - found.u) < config.shortest:
            continue
        spans[before] = (low, found.t)
        spans[after] = (found.u, spans[after][1])
        ended.add(before)
        started.add(after)
        joints.append((before, after))
    out = (_on(spline, spans[spline.id], spline.id in started, spline.id in ended, model) for spline in splines)
    return SplineMap(tuple(out)), tuple(joints)


def _crossings(
    by_id: dict[int, MapSpline], in_turn: Sequence[WallsInTurn], config: TrimmingConfig, leeway: float
) -> Iterator[tuple[float, int, int, Crossing]]:
    """Of pairs that are a corner how far (m) their ends lie from the crossing, their ids, and the crossing."""
    for pair in in_turn:
        if pair.before == pair.after or pair.before not in by_id or pair.after not in by_id:
            continue
        before, after = by_id[pair.before], by_id[pair.after]
        found = end_crossing(before, after)
        if found is None or max(pair.end - found.t, found.u - pair.start) > leeway:
            continue
        short, other = found.t - before.span[1], after.span[0] - found.u
        missing = max(short, 0.0) + max(other, 0.0)
        if missing <= max(config.gap, config.gap_ratio * pair.spacing) and min(short, other) >= -config.gap:
            yield abs(short) + abs(other), before.id, after.id, found


def _on(spline: MapSpline, span: tuple[float, float], at_start: bool, at_end: bool, model: Model) -> MapSpline:
    """The spline on this stretch, its curve defined a little beyond its ends at corners, which move when the map is
    solved again."""
    if not (at_start or at_end):
        return spline
    wide = (span[0] - LOOSE * at_start, span[1] + LOOSE * at_end)
    return replace(spline, curve=model.cut(spline.curve.reaching(wide), wide), span=span)
