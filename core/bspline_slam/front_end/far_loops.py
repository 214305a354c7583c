"""Places seen again after a drift too large for a search around the present pose: where the last key scans, taken
together, fit only one place inside the joint uncertainty of then and now, again and again."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closer import LoopCloser, window
from bspline_slam.front_end.loop_closure import LoopConfig, Proposal
from bspline_slam.front_end.scan_matching import MatchingConfig
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.front_end.whole_map import PlaceConfig, WholeMap, Window, agree, last_points, proposal_at
from bspline_slam.graph import PoseFactor


@dataclass(frozen=True, slots=True)
class FarLoopConfig(PlaceConfig):
    """When a far loop is looked for (m travelled `between` two tries, more where that is less than a `share` of the way
    since the last closure; and since an old place was left), how far around (standard deviations), and how many finds
    must agree, `on` (m) or more travelled from one to the next and no more than `patience`."""

    together: int = 16
    points: int = 240
    facings: int = 6
    least_score: float = 0.65
    least_margin: float = 0.05
    between: float = 2.0
    share: float = 0.05
    least_travel: float = 20.0
    sigmas: float = 3.0
    finds: int = 3
    on: float = 1.5
    patience: float = 8.0


def chain_covariance(
    factors: Sequence[PoseFactor], closures: Sequence[Proposal], poses: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3 3"]:
    """Covariance (world frame) of the last key pose seen from each, as errors of the steps between key scans add up;
    what a closure spans hangs together without an error."""
    n = len(poses)
    spans = np.array([(one.factor.i + 1, one.factor.j + 1) for one in closures], dtype=np.int64).reshape(-1, 2)
    begun, ended = (np.bincount(spans[:, end], minlength=n + 1) for end in (0, 1))
    steps = np.flatnonzero(np.cumsum(begun - ended)[:n] == 0)[1:]
    told, loose = np.zeros((n, 3, 3)), set(steps.tolist())
    for factor in factors:
        if factor.j in loose:
            told[factor.j] += factor.sqrt_information.T @ factor.sqrt_information
    lever = np.zeros((len(steps), 3, 3))
    lever[:, :2, :2], lever[:, 2, 2] = se2.rotation(poses[steps, 2]), 1.0
    lever[:, :2, 2] = (poses[-1, :2] - poses[steps, :2])[:, ::-1] * (-1.0, 1.0)
    errors = np.zeros((n, 3, 3))
    errors[steps] = lever @ np.linalg.inv(told[steps] + 1e-6 * np.eye(3)) @ lever.swapaxes(1, 2)
    return np.cumsum(errors[::-1], axis=0)[::-1] - errors


@dataclass
class FarCloser:
    """State of the search: the finds that agree so far, and where the next try is due (m travelled)."""

    config: FarLoopConfig
    matching: MatchingConfig
    tracking: TrackingConfig
    loops: LoopConfig
    waiting: list[Proposal] = field(default_factory=list)
    _next: float = 0.0

    def look(
        self,
        keys: Sequence[KeyScan],
        poses: Float[np.ndarray, "n 3"],
        factors: Sequence[PoseFactor],
        closer: LoopCloser,
    ) -> tuple[Proposal, ...]:
        """Closures that agree on where the last key scan lies, or nothing; `factors` tie each key scan to the next."""
        c, travel = self.config, keys[-1].travel
        if travel < self._next:
            return ()
        self._next = travel + (c.on if self.waiting else max(c.between, c.share * (travel - closer.closed_at)))
        found = self._find(keys, poses, factors, closer)
        if found is None or not found.closure.accepted:
            self.waiting = [one for one in self.waiting if travel - keys[one.j].travel < c.patience]
            return ()
        agreeing = [other for other in self.waiting if agree(other, found, poses, c)]
        self.waiting, self._next = [*agreeing, found], travel + c.on
        if len(self.waiting) < c.finds:
            return ()
        fresh, self.waiting = tuple(self.waiting), []
        return fresh

    def _find(
        self,
        keys: Sequence[KeyScan],
        poses: Float[np.ndarray, "n 3"],
        factors: Sequence[PoseFactor],
        closer: LoopCloser,
    ) -> Proposal | None:
        """The last key scan matched at the only place inside its uncertainty where it fits together with those before
        it."""
        c = self.config
        old = bisect_left(keys, keys[-1].travel - c.least_travel, key=lambda key: key.travel)
        if old == 0:
            return None
        covariance = chain_covariance(factors, closer.accepted, poses)[:old]
        usual, _ = window(keys[-1].travel - closer.closed_at, self.loops)
        reach = c.sigmas * np.sqrt(covariance[:, 0, 0] + covariance[:, 1, 1])
        away = np.hypot(*(poses[:old, :2] - poses[-1, :2]).T)
        known = np.flatnonzero((reach > usual) & (away < reach + self.loops.radius))
        if len(known) == 0:
            return None
        turn = min(c.sigmas * float(np.sqrt(covariance[known, 2, 2].max())), np.pi)
        there = Window(poses[-1], float(reach[known].max()), turn)
        points = last_points(keys, poses, max(len(keys) - c.together, old), c)
        found = WholeMap.of(keys, poses, known, c, self.matching).only_place(points, c, there)
        if found is None:
            return None
        args = (self.loops, self.matching, self.tracking, "far off, and fits nowhere else: ")
        return proposal_at(found, keys, poses, known, *args)
