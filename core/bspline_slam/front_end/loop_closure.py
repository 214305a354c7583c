"""Places seen again: candidates, search inside the pose uncertainty, verification, and the verdict on each."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.scan_matching import Match, MatchingConfig, find, find_with_icp
from bspline_slam.front_end.tracking import KeyScan, TrackingConfig, matched_information
from bspline_slam.graph import PoseFactor, square_root


@dataclass(frozen=True, slots=True)
class LoopConfig:
    """Which earlier places are tried (m travelled since, m apart), how far the search reaches, and what is believed.

    The search window grows from `least_reach` by `drift` metres per metre travelled since the last accepted closure,
    at most to `most_reach`; beyond `wide_reach` it is searched in blocks of `wide_block` cells. Only closures that know
    the place to `settled` (m, 1 σ) in every direction count as such. A closure that would move the map by more than
    `sure_distance` or `sure_turn` waits until a second one, at most `confirm_travel` on, agrees with it within
    `agree_distance` and `agree_turn`. One that the finished poses still put so far off, and by more than
    `contradiction` standard deviations, was wrong.
    """

    least_travel: float = 8.0
    radius: float = 3.5
    half_width: int = 6
    tries: int = 2
    apart: int = 15
    least_reach: float = 0.4
    drift: float = 0.03
    most_reach: float = 6.0
    least_turn: float = np.deg2rad(8.0)
    turn_drift: float = np.deg2rad(0.4)
    most_turn: float = np.deg2rad(40.0)
    wide_block: int = 8
    least_score: float = 0.55
    least_inliers: float = 0.6
    wide_reach: float = 1.0
    sure_distance: float = 0.1
    sure_turn: float = np.deg2rad(2.0)
    confirm_travel: float = 8.0
    agree_distance: float = 0.15
    agree_turn: float = np.deg2rad(3.0)
    contradiction: float = 10.0
    settled: float = 0.1
    kernel: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class LoopClosure:
    """A proposed tie between two key scans, by scan index.

    `measured` is the pose of `scan` seen from `earlier`, with `covariance` (frame of `scan`); `score` the
    correlation (0…1) and `inliers` the share of beams that lie on the earlier map; `accepted` the verdict and
    `reason` its sentence. One that is `waiting` is not accepted yet: a second one has to agree with it.
    """

    earlier: int
    scan: int
    measured: Float[np.ndarray, "3"]
    covariance: Float[np.ndarray, "3 3"]
    score: float
    inliers: float
    accepted: bool
    reason: str
    waiting: bool = False

    @property
    def verdict(self) -> str:
        """In one word."""
        return "accepted" if self.accepted else "waiting" if self.waiting else "rejected"


@dataclass(frozen=True, eq=False, slots=True)
class Proposal:
    """A closure, and the factor that it is between two key scans."""

    closure: LoopClosure
    factor: PoseFactor

    @property
    def i(self) -> int:
        """The earlier key scan, by its number among key scans."""
        return self.factor.i

    @property
    def j(self) -> int:
        """The later key scan."""
        return self.factor.j

    def off(self, poses: Float[np.ndarray, "n 3"]) -> tuple[Float[np.ndarray, "3"], float]:
        """Where these key poses have the later scan, seen from where the closure puts it, and how many standard
        deviations of the closure that is."""
        off = se2.between(self.closure.measured, se2.between(poses[self.i], poses[self.j]))
        return off, float(np.linalg.norm(self.factor.sqrt_information @ off))


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


def proposal_of(
    match: Match,
    keys: Sequence[KeyScan],
    poses: Float[np.ndarray, "n 3"],
    i: int,
    config: LoopConfig,
    tracking: TrackingConfig,
    preface: str = "",
) -> Proposal:
    """A match of the last key scan as a closure with key scan i, judged; `preface` opens the sentence that says why."""
    j = len(keys) - 1
    accepted, reason = judge(match, config)
    information = matched_information(match, tracking) + 1e-6 * np.eye(3)
    measured = se2.between(poses[i], match.pose)
    closure = LoopClosure(
        keys[i].scan, keys[j].scan, measured, np.linalg.inv(information), match.score, match.inliers, accepted,
        preface + reason,
    )  # fmt: skip
    return Proposal(closure, PoseFactor(i, j, measured, square_root(information), "loop", config.kernel))


def judge(match: Match, config: LoopConfig) -> tuple[bool, str]:
    """Whether a match is good enough to close a loop, and the sentence that says why."""
    if match.score < config.least_score:
        return False, f"correlation {match.score:.3f} is below {config.least_score:.2f}"
    if match.inliers < config.least_inliers:
        return False, f"only {match.inliers:.0%} of the beams lie on the earlier map, {config.least_inliers:.0%} asked"
    return True, f"correlation {match.score:.2f}, {match.inliers:.0%} of the beams lie on the earlier map"


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
