"""Corners of walls: where the end of one spline and the start of the next meet.

Scans run with the sensor on the left of what they see, and so do the curves made of them: as one walks along the walls
of a room, the end of a curve comes before the start of the next.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline
from bspline_slam.flat_curves import FlatCurves
from bspline_slam.spline_map import MapSpline, SplineMap

LEAST_SINE = 0.5
"""Curves that cross at an angle of a smaller sine do so at a place that hardly anything tells."""
MOST_STEPS, FARTHEST = 20, 1.0
"""Limits for finding a crossing: steps, and how far along a curve it may lie from where the search began (m)."""
LOOSE = 0.05
"""Curves whose crossing lies farther than this (m) from an end of theirs that was there have come apart."""
CLOSE, STILL, SAME = 1e-11, 1e-9, 1e-6
"""Curves this near to each other (m) cross; ends that would move less than this (m) stay; ends this near to each other
are one corner, rounded in a file or not."""

Joint = tuple[int, int]
"""The id of the spline whose end lies at a corner, and of that which starts there."""


@dataclass(frozen=True, eq=False, slots=True)
class Corner:
    """The end of the spline `before` and the start of the spline `after`, both at `point` (m, world frame); walking
    along them, one turns left by `turn` (rad): in a room towards the room, round a pillar (negative) away from it."""

    before: int
    after: int
    point: Float[np.ndarray, "2"]
    turn: float

    @property
    def joint(self) -> Joint:
        return self.before, self.after


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where two curves cross: the parameter of each, and by how much the second is turned from the first (rad)."""

    t: float
    u: float
    turn: float


def crossing(before: BSpline, t: float, after: BSpline, u: float) -> Crossing | None:
    """The crossing of two curves to which Newton's method leads from these parameters; None where it leads to none, or
    to one too far off or too slanting. Curves go on beyond their domains as the polynomials that they are there."""
    at, start = np.array([t, u]), np.array([t, u])
    for _ in range(MOST_STEPS):
        off = after(at[1:])[0] - before(at[:1])[0]
        one, other = before(at[:1], 1)[0], after(at[1:], 1)[0]
        sine = float(one[0] * other[1] - one[1] * other[0])
        if abs(sine) < LEAST_SINE * float(np.linalg.norm(one) * np.linalg.norm(other)):
            return None
        if np.abs(off).max() < CLOSE:
            return Crossing(float(at[0]), float(at[1]), float(np.arctan2(sine, one @ other)))
        at = at + np.array([off[0] * other[1] - off[1] * other[0], off[0] * one[1] - off[1] * one[0]]) / sine
        if np.abs(at - start).max() > FARTHEST:
            return None
    return None


def end_crossing(before: MapSpline, after: MapSpline) -> Crossing | None:
    """Where the end of a spline crosses the start of another, if it does."""
    return crossing(before.curve, before.span[1], after.curve, after.span[0])


def ends_and_starts(splines: SplineMap, within: float) -> Iterator[tuple[int, int]]:
    """The places in the map of all pairs of splines, the end of the first of which lies no farther than `within` (m)
    from the start of the second, along either axis."""
    curves = FlatCurves.of([spline.curve for spline in splines])
    spans = np.array([spline.span for spline in splines], dtype=float).reshape(-1, 2)
    ends, starts = curves.points_at(spans[:, 1]), curves.points_at(spans[:, 0])
    order = np.argsort(starts[:, 0], kind="stable")
    first, last = (np.searchsorted(starts[order, 0], ends[:, 0] + way * within) for way in (-1.0, 1.0))
    for i, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        for j in order[a:b].tolist():
            if i != j and abs(ends[i, 1] - starts[j, 1]) <= within:
                yield i, j


def corners_of(splines: SplineMap) -> tuple[Corner, ...]:
    """Every place at which the end of a spline is the start of another that goes on in another direction."""
    found = []
    for i, j in ends_and_starts(splines, SAME):
        before, after = splines.splines[i], splines.splines[j]
        if (turn := _turn(before, after)) is not None:
            found.append(Corner(before.id, after.id, before.curve(np.array([before.span[1]]))[0], turn))
    return tuple(found)


def _turn(before: MapSpline, after: MapSpline) -> float | None:
    """By how much one turns left from the end of a spline into another (rad); None where that is no corner."""
    one, other = before.curve(np.array([before.span[1]]), 1)[0], after.curve(np.array([after.span[0]]), 1)[0]
    turn = float(np.arctan2(one[0] * other[1] - one[1] * other[0], one @ other))
    return turn if abs(np.sin(turn)) > LEAST_SINE / 2 else None


def meeting(splines: SplineMap, joints: Iterable[Joint]) -> SplineMap:
    """The map whose splines end and start where those of these joints cross; control points stay as they are. Joints
    that have come apart, or whose crossing lies beyond the domain of a curve, are none any more."""
    spans = {spline.id: spline.span for spline in splines}
    by_id = {spline.id: spline for spline in splines}
    for first, second in joints:
        if first in by_id and second in by_id and (found := _held(by_id[first], by_id[second])) is not None:
            spans[first] = (spans[first][0], found.t)
            spans[second] = (found.u, spans[second][1])
    return SplineMap(tuple(s if s.span == spans[s.id] else replace(s, span=spans[s.id]) for s in splines))


def _held(before: MapSpline, after: MapSpline) -> Crossing | None:
    """Where the end of a spline still crosses the start of another, if these are elsewhere."""
    found = end_crossing(before, after)
    if found is None or not STILL < max(abs(found.t - before.span[1]), abs(found.u - after.span[0])) <= LOOSE:
        return None
    inside = before.span[0] < found.t <= before.curve.domain[1] and after.curve.domain[0] <= found.u < after.span[1]
    return found if inside else None
