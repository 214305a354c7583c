"""A lost robot found again: its last key scans, taken together, are looked for on the whole map of before.

Search through the map by branch and bound over ever smaller squares (Hess et al. 2016), all headings. A place counts
only if no other one is nearly as good, if the scan itself fits there like a loop closure, and if the next key scan
says the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.loop_closure import LoopConfig, Proposal, proposal_of
from bspline_slam.front_end.scan_matching import MatchingConfig, find_with_icp, gather, likelihood_field
from bspline_slam.front_end.tracking import KeyScan, TrackingConfig
from bspline_slam.kernels import anywhere


@dataclass(frozen=True, slots=True)
class RelocalisationConfig:
    """How a lost robot is looked for (m, rad).

    `together` key scans are looked for as one, with beams no longer than `reach`, at most `points` of them, at `turns`
    headings, on a field of cells of size `cell`, or larger ones where the map would have more than `most_cells`. A
    place needs a correlation of `least_score`, and no other one, `apart` or `apart_turn` from it, may come within
    `margin` of it. Two key scans must agree within `agree_distance` and `agree_turn`. After each failure the robot
    travels on by `patience` times as far as since it was lost, and at least by `least_travel`, before the next try.
    """

    together: int = 6
    reach: float = 20.0
    points: int = 120
    cell: float = 0.1
    most_cells: float = 2e6
    levels: int = 7
    turns: int = 480
    least_score: float = 0.6
    margin: float = 0.1
    apart: float = 1.0
    apart_turn: float = np.deg2rad(10.0)
    agree_distance: float = 0.3
    agree_turn: float = np.deg2rad(3.0)
    least_travel: float = 0.5
    patience: float = 0.5


@dataclass
class Relocaliser:
    """State of the search for one piece of the drive: the key scans from number `since` on, whose tie to those before
    is in doubt. `waiting` is a place found that wants a second opinion; `settled` says that the piece was found."""

    since: int
    config: RelocalisationConfig
    matching: MatchingConfig
    tracking: TrackingConfig
    loops: LoopConfig
    waiting: Proposal | None = None
    settled: bool = False
    _next: float = 0.0
    _bounds: np.ndarray | None = None
    _cell: float = 0.0
    _origin: Float[np.ndarray, "2"] = field(default_factory=lambda: np.zeros(2))

    def look(
        self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], strays: Sequence[int]
    ) -> tuple[Proposal, ...]:
        """Two closures that agree on where the last key scan lies, or nothing. Key scans that are `strays` are no part
        of the map."""
        travel = keys[-1].travel - keys[self.since].travel
        if len(keys) - self.since < 3 or (self.waiting is None and travel < self._next):
            return ()
        self._next = travel + max(self.config.least_travel, self.config.patience * travel)
        before, self.waiting = self.waiting, None
        if self._bounds is None:
            self._read_map(keys, poses, strays)
        found = self._anywhere(keys, poses)
        if found is None:
            return ()
        proposal = self._proposal(keys, poses, found)
        if not proposal.closure.accepted:
            return ()
        if before is not None and self._agree(before, proposal, poses):
            self.settled = True
            return before, proposal
        self.waiting = proposal
        return ()

    def _anywhere(self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "3"] | None:
        """The only pose on the map of before at which the last key scans fit; None where there is none or several."""
        c, points = self.config, self._last_points(keys, poses)
        if len(points) == 0:
            return None
        args = (self._bounds, self._origin, self._cell, points, c.turns)
        *pose, score = anywhere.search_anywhere(*args, c.least_score, np.zeros(3), -1.0, -1.0)
        if score <= c.least_score:
            return None
        found = np.array(pose)
        *_, second = anywhere.search_anywhere(*args, score - c.margin, found, c.apart, c.apart_turn)
        return None if second > score - c.margin else found

    def _read_map(self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], strays: Sequence[int]) -> None:
        """The pyramid of the field of all key scans before the piece."""
        c = self.config
        known = [k for k in range(self.since) if k not in strays]
        old = gather([keys[k].points for k in known], poses[known])
        self._cell = max(c.cell, float(np.sqrt(np.prod(np.ptp(old.points, axis=0)) / c.most_cells)))
        coarse = likelihood_field(old, replace(self.matching, cell=self._cell, field_sigma=self._cell), 1)
        self._bounds, self._origin = anywhere.pyramid(coarse.values, c.levels), coarse.origin

    def _last_points(self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "m 2"]:
        """Beam ends of the last key scans of the piece in the frame of the last one, no two near each other."""
        c, first = self.config, max(len(keys) - self.config.together, self.since)
        rest = [se2.transform(se2.between(poses[-1], poses[k]), keys[k].points.points) for k in range(first, len(keys))]
        points = np.concatenate(rest)
        points = points[np.hypot(*points.T) < c.reach]
        _, kept = np.unique(np.floor(points / c.cell).astype(np.int64), axis=0, return_index=True)
        points = points[np.sort(kept)]
        return points[:: max(len(points) // c.points, 1)]

    def _proposal(
        self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], found: Float[np.ndarray, "3"]
    ) -> Proposal:
        """The last key scan matched to the surroundings of the key scan of before that is nearest to that place."""
        away = np.hypot(*(poses[: self.since, :2] - found[:2]).T)
        i = int(np.argmin(away + 0.5 * np.abs(se2.wrap(poses[: self.since, 2] - found[2]))))
        near = np.argsort(away)[: 2 * self.loops.half_width + 1]
        places, scan = [keys[k].points for k in near], keys[-1].points
        match = find_with_icp(places, poses[near], scan, found, self.matching, 0.3, np.deg2rad(3.0))
        return proposal_of(match, keys, poses, i, self.loops, self.tracking, "lost before, found again: ")

    def _agree(self, before: Proposal, now: Proposal, poses: Float[np.ndarray, "n 3"]) -> bool:
        """Whether both put the later key scan at the same place, by the way from one to the other."""
        first = se2.compose(poses[before.i], before.closure.measured)
        expected = se2.compose(first, se2.between(poses[before.j], poses[now.j]))
        off = se2.between(expected, se2.compose(poses[now.i], now.closure.measured))
        return bool(np.hypot(off[0], off[1]) < self.config.agree_distance and abs(off[2]) < self.config.agree_turn)
