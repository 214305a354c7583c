"""A place seen again: the tie between two key scans, how good it is, and the verdict on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.match_information import matched_information
from bspline_slam.front_end.scan_matching import Match
from bspline_slam.front_end.tracking_config import TrackingConfig
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
