"""Closing loops: earlier places that come into question, the search inside the pose uncertainty, and which finds are
believed."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closure import LoopClosure, LoopConfig, Proposal, proposal_of
from bspline_slam.front_end.scan_matching import MatchingConfig, find, find_with_icp
from bspline_slam.front_end.tracking_config import TrackingConfig

THREADS = 2
"""So many places are compared at once."""


def candidates(keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], reach: float, config: LoopConfig) -> list[int]:
    """Key scans worth comparing with the last one: travelled away from since, near by, and apart from each other."""
    old = bisect_left(keys, keys[-1].travel - config.least_travel, key=lambda key: key.travel)
    away = np.hypot(*(poses[:old, :2] - poses[-1, :2]).T)
    near = np.flatnonzero(away < config.radius + reach)
    turned = np.abs(se2.wrap(poses[near, 2] - poses[-1, 2]))
    chosen: list[int] = []
    for k in near[np.argsort(away[near] + 0.5 * turned)]:
        if all(abs(int(k) - other) > config.apart for other in chosen):
            chosen.append(int(k))
        if len(chosen) == config.tries:
            break
    return chosen


def window(travelled: float, config: LoopConfig) -> tuple[float, float]:
    """Reach (m) and turn (rad) of the search after so many metres without an accepted closure."""
    reach = min(config.least_reach + config.drift * travelled, config.most_reach)
    turn = min(config.least_turn + config.turn_drift * travelled, config.most_turn)
    return reach, turn


def propose(
    keys: Sequence[KeyScan],
    poses: Float[np.ndarray, "n 3"],
    i: int,
    travelled: float,
    config: LoopConfig,
    matching: MatchingConfig,
    tracking: TrackingConfig,
) -> Proposal:
    """Match the last key scan to the surroundings of key scan i and judge the result. By ICP too where the correlation
    is high and yet few beams lie on the map, for then it was the refinement that went astray."""
    j = len(keys) - 1
    reach, turn = window(travelled, config)
    first, last = max(i - config.half_width, 0), min(i + config.half_width + 1, j)
    block = config.wide_block if reach > config.wide_reach else matching.block
    places = [key.points for key in keys[first:last]]
    match = find(places, poses[first:last], keys[j].points, poses[j], matching, reach, turn, block)
    if match.score >= config.least_score and match.inliers < config.least_inliers:
        match = find_with_icp(places, poses[first:last], keys[j].points, poses[j], matching, reach, turn, block)
    return proposal_of(match, keys, poses, i, config, tracking)


@dataclass
class LoopCloser:
    """State of loop closing: every proposal with its verdict, those that wait for a second opinion, and those that are
    being made.

    A key scan is compared with each place in a thread of its own, while the scans up to the next one are read. The
    verdict waits for that next one, so that nothing hangs on how fast the threads are.
    """

    config: LoopConfig
    matching: MatchingConfig
    tracking: TrackingConfig
    closures: list[LoopClosure] = field(default_factory=list)
    accepted: list[Proposal] = field(default_factory=list)
    waiting: list[Proposal] = field(default_factory=list)
    closed_at: float = 0.0
    _asked: list[Future[Proposal]] = field(default_factory=list)
    _pool: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(THREADS, "loop closing"))

    @property
    def told(self) -> tuple[LoopClosure, ...]:
        """Every proposal with its verdict, and those still waiting for one."""
        reason = f"it would move the map, and waits for a second closure within {self.config.confirm_travel:g} m"
        waiting = (replace(one.closure, accepted=False, waiting=True, reason=reason) for one in self.waiting)
        return (*self.closures, *waiting)

    def look(self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"]) -> None:
        """Begin to compare the last key scan with earlier places."""
        travelled = keys[-1].travel - self.closed_at
        reach, _ = window(travelled, self.config)
        places = candidates(keys, poses, reach, self.config)
        held = list(keys) if places else []
        self._asked = [
            self._pool.submit(propose, held, poses, i, travelled, self.config, self.matching, self.tracking)
            for i in places
        ]

    def found(self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"]) -> list[Proposal]:
        """The closures newly accepted of what was last looked at, now that the key scans are at these poses."""
        fresh: list[Proposal] = []
        for proposal in [asked.result() for asked in self._asked]:
            if not proposal.closure.accepted:
                self.closures.append(proposal.closure)
            elif self._expected(proposal, poses):
                fresh.append(proposal)
            else:
                fresh.extend(self._confirm(proposal, keys, poses))
        self._asked = []
        self._forget(keys)
        settled = [keys[proposal.j].travel for proposal in fresh if self._settles(proposal)]
        self.closed_at = max([self.closed_at, *settled])
        if fresh:
            self.accepted.extend(fresh)
            self.closures.extend(proposal.closure for proposal in fresh)
        return fresh

    def reject_contradicted(self, poses: Float[np.ndarray, "n 3"]) -> bool:
        """Take back closures that the poses of a finished map contradict beyond doubt; whether there were any."""
        kept: list[Proposal] = []
        rejected: dict[tuple[int, int], LoopClosure] = {}
        for proposal in self.accepted:
            off, sigmas = proposal.off(poses)
            if sigmas <= self.config.contradiction or self._expected(proposal, poses):
                kept.append(proposal)
                continue
            far = f"{np.hypot(off[0], off[1]):.2f} m and {np.degrees(abs(off[2])):.1f}°"
            reason = f"the finished map has these scans {far} from where it puts them, {sigmas:.0f} standard deviations"
            closure = replace(proposal.closure, accepted=False, reason=reason)
            rejected[closure.earlier, closure.scan] = closure
        self.accepted = kept
        self.closures = [rejected.get((one.earlier, one.scan), one) for one in self.closures]
        return bool(rejected)

    def accept(self, found: Sequence[Proposal], keys: Sequence[KeyScan]) -> None:
        """Accept closures that were found and confirmed elsewhere."""
        self.accepted.extend(found)
        self.closures.extend(proposal.closure for proposal in found)
        self.closed_at = keys[-1].travel

    def take(self, found: Sequence[Proposal], keys: Sequence[KeyScan], since: int) -> None:
        """Accept the closures of a relocalisation in place of those that tied the key scans from number `since` on to
        earlier ones."""
        self.accepted = [p for p in self.accepted if not p.i < since <= p.j]
        self.waiting = []
        self.accept(found, keys)

    def _settles(self, proposal: Proposal) -> bool:
        """Whether a closure says in all directions where the scan is; beside a long wall it says little of the way
        along it."""
        weakest = float(np.linalg.eigvalsh(proposal.closure.covariance[:2, :2])[-1])
        return weakest < self.config.settled**2

    def _expected(self, proposal: Proposal, poses: Float[np.ndarray, "n 3"]) -> bool:
        """Whether a closure says what the estimate says already."""
        off, _ = proposal.off(poses)
        return bool(np.hypot(off[0], off[1]) < self.config.sure_distance and abs(off[2]) < self.config.sure_turn)

    def _confirm(self, proposal: Proposal, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"]) -> list[Proposal]:
        """The waiting proposals that agree with this one, and itself; else it starts to wait (pairwise
        consistency). Proposals of which none knows the place in all directions prove nothing together."""
        agreeing = [other for other in self.waiting if other.j != proposal.j and self._agree(other, proposal, poses)]
        if not agreeing or not any(map(self._settles, (*agreeing, proposal))):
            self.waiting.append(proposal)
            return []
        self.waiting = [other for other in self.waiting if other not in agreeing]
        return [*agreeing, proposal]

    def _agree(self, a: Proposal, b: Proposal, poses: Float[np.ndarray, "n 3"]) -> bool:
        """Whether both closures put the later scan at the same place, through the chain of key scans between them."""
        from_a = se2.compose(se2.compose(poses[a.i], a.closure.measured), se2.between(poses[a.j], poses[b.j]))
        from_b = se2.compose(poses[b.i], b.closure.measured)
        off = se2.between(from_a, from_b)
        return bool(np.hypot(off[0], off[1]) < self.config.agree_distance and abs(off[2]) < self.config.agree_turn)

    def _forget(self, keys: Sequence[KeyScan]) -> None:
        """Proposals that found no second opinion in time are rejected, with the reason."""
        stale = [p for p in self.waiting if keys[-1].travel - keys[p.j].travel > self.config.confirm_travel]
        for proposal in stale:
            reason = f"it would move the map, and no second closure within {self.config.confirm_travel:g} m agrees"
            self.closures.append(replace(proposal.closure, accepted=False, reason=reason))
        self.waiting = [p for p in self.waiting if p not in stale]
