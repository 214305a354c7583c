"""Which key scans and which splines of a recorded log a small map is made of: the rule behind Fig. 9.

The first scan is the key scan that sees the most wall. Then, one by one, comes the scan that sees the most wall that
fewer than three of the chosen ones have seen, among those of whose wall the chosen ones have seen at least a half, so
that each finds its place on the map of those before it. A sight counts when it shares wall with what the scans before
saw of its spline. The splines are those of which two or more scans saw the longest stretch. What is one wall, and who
saw it, is what the pipeline found out in the whole log.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from bspline_slam.sights import KeyObservations, collect_sights, find_feet
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import SplineMap

CELL = 0.25
"""Wall is counted in stretches of this length (m)."""
LEAST_BEAMS, LEAST_LENGTH = 8, 0.3
"""A sight of a spline has at least so many beams over so much of it (m)."""
GATE = 0.05
"""Half of the beams of a sight lie closer than this to the spline as the whole log gives it (m)."""
OFTEN = 3
"""Wall that so many scans saw is worth no further one."""
OVERLAP = 0.5
"""Least share of a scan's wall that the scans before it have seen."""

Wall = frozenset[tuple[int, int]]
"""Cells as (spline, number along it)."""


@dataclass(frozen=True, eq=False, slots=True)
class WallSight:
    """The largest piece of a key scan that saw one spline: its points in the robot's frame, and the cells."""

    spline: int
    points: Float[np.ndarray, "m 2"]
    cells: Wall


@dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """Positions among the key scans, in the order in which they were chosen, the ids of the splines, and who saw
    what: `sights[i]` belongs to the i-th chosen scan."""

    keys: tuple[int, ...]
    splines: tuple[int, ...]
    sights: tuple[tuple[WallSight, ...], ...]


def choose(snapshot: Snapshot, scans: int, splines: int) -> Choice:
    """At most so many scans and splines of a finished run, by the rule above."""
    seen = wall_sights(snapshot.observations, snapshot.poses[snapshot.key_scans], snapshot.map)
    keys = chosen_scans([_wall(sights) for sights in seen], scans)
    joined = continuing([seen[key] for key in keys])
    ids = chosen_splines([_wall(sights) for sights in joined], splines)
    kept = [tuple(sight for sight in sights if sight.spline in ids) for sights in joined]
    useful = [i for i, sights in enumerate(kept) if sights]
    return Choice(tuple(keys[i] for i in useful), ids, tuple(kept[i] for i in useful))


def _wall(sights: Sequence[WallSight]) -> Wall:
    return frozenset().union(*(sight.cells for sight in sights))


def continuing(seen: Sequence[Sequence[WallSight]]) -> list[list[WallSight]]:
    """The sights that share wall with what scans before them saw of their spline, and the first of each spline:
    bearings cannot tell how far another stretch of the same wall is away."""
    known: dict[int, Wall] = {}
    kept: list[list[WallSight]] = []
    for sights in seen:
        kept.append([sight for sight in sights if sight.cells & known.get(sight.spline, sight.cells)])
        known |= {sight.spline: known.get(sight.spline, frozenset()) | sight.cells for sight in kept[-1]}
    return kept


def chosen_scans(walls: Sequence[Wall], count: int) -> tuple[int, ...]:
    """Greedily, the scans that see the most wall not yet seen often enough; fewer where no more overlap."""
    chosen: list[int] = []
    times: Counter[tuple[int, int]] = Counter()
    while len(chosen) < count:
        gains = [0 if k in chosen else _gain(wall, times, first=not chosen) for k, wall in enumerate(walls)]
        if max(gains, default=0) == 0:
            break
        chosen.append(int(np.argmax(gains)))
        times.update(walls[chosen[-1]])
    return tuple(chosen)


def _gain(wall: Wall, times: Mapping[tuple[int, int], int], *, first: bool) -> int:
    known = sum(cell in times for cell in wall)
    if not first and known < OVERLAP * len(wall):
        return 0
    return sum(times.get(cell, 0) < OFTEN for cell in wall)


def chosen_splines(walls: Sequence[Wall], count: int) -> tuple[int, ...]:
    """The splines of which at least two scans saw the longest stretch, longest first."""
    times = Counter(cell for wall in walls for cell in wall)
    twice = Counter(spline for (spline, _), seen in times.items() if seen > 1)
    return tuple(sorted(twice, key=lambda spline: (-twice[spline], spline))[:count])


def wall_sights(
    keys: Sequence[KeyObservations], poses: Float[np.ndarray, "n 3"], splines: SplineMap
) -> list[list[WallSight]]:
    """For each key scan the splines that it saw well enough, each by the association with the most beams."""
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, poses, GATE)
    found: list[dict[int, WallSight]] = [{} for _ in keys]
    for a, b in pairwise(np.flatnonzero(np.diff(sights.piece, prepend=-1, append=-1))):
        t, pose, spline = feet.t[a:b], int(sights.pose[a]), splines.splines[sights.spline[a]].id
        before = found[pose].get(spline)
        most = LEAST_BEAMS - 1 if before is None else len(before.points)
        if b - a > most and np.ptp(t) >= LEAST_LENGTH and np.median(np.abs(feet.across[a:b])) < GATE:
            cells = range(int(np.ceil(t.min() / CELL)), int(np.floor(t.max() / CELL)) + 1)
            wall = frozenset((spline, cell) for cell in cells)
            found[pose][spline] = WallSight(spline, sights.points[a:b], wall)
    return [list(sights.values()) for sights in found]
