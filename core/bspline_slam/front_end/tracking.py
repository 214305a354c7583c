"""Where each scan lies relative to the last key scans: predict, search, refine, and decide whether it becomes a
key scan."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.contradiction import compared
from bspline_slam.front_end.key_chain import KeyChain
from bspline_slam.front_end.match_information import matched_information, turned
from bspline_slam.front_end.motion import MotionConfig, guess_information, guesses, step_information, surprise
from bspline_slam.front_end.place_search import searched
from bspline_slam.front_end.scan_matching import Match, MatchingConfig, PointSet, point_set, refine
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.front_end.wheels import Wheels
from bspline_slam.graph import PoseFactor, square_root
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import SegmentationConfig

NOTHING = PointSet(np.zeros((0, 2)), np.zeros((0, 2)))
"""What a blocked scan shows of the world."""


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """What tracking says of one scan: pose before and after looking at it, its correlation, whether it is a key scan,
    and whether its odometry was `unfit`, that is, not believed because it did not fit what scans show."""

    predicted: Float[np.ndarray, "3"]
    pose: Float[np.ndarray, "3"]
    score: float
    lost: bool
    key: bool
    unfit: bool = False


@dataclass
class Tracker:
    """State of tracking: the chain of key scans with all other scans tied to it, what wheels are worth, the late steps,
    how many scans in a row were lost by now, and the last scan that was looked at, which the next ones are seen from.
    """

    config: TrackingConfig
    matching: MatchingConfig
    segmentation: SegmentationConfig
    motion: MotionConfig
    chain: KeyChain = field(init=False)
    wheels: Wheels = field(init=False)
    _looked_at: int = 0
    _ranges: Float[np.ndarray, "beams"] = field(default_factory=lambda: np.zeros(0))
    _lost: int = 0
    _late: list[Float[np.ndarray, "3"]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.chain = KeyChain(self.config.local_scans, self.matching)
        self.wheels = Wheels(self.motion)

    def track(self, scan: LaserScan, odometry: Float[np.ndarray, "3"] | None) -> Tracked:
        """Place the next scan of the log; `odometry` is its odometry pose, None where the log has none."""
        if not self.chain.keys:
            self.chain.begin(scan.index, self._points(scan))
            self.wheels.at_key(odometry)
            self._keep(scan, odometry)
            return Tracked(se2.IDENTITY, se2.IDENTITY, 1.0, lost=False, key=True)

        previous, wheels = self.chain.pose_of(self._looked_at), self.wheels.step(odometry)
        believed = wheels is not None and self.wheels.fit
        steps = None if wheels is None else (self.wheels.unbiased(wheels), wheels)
        tries = guesses(steps, self._late, self.motion, believed=believed)
        predicted = se2.compose(previous, tries[0])
        if wheels is not None and believed and self._still(wheels) and self._unchanged(scan):
            self.chain.hang(predicted)
            return Tracked(predicted, predicted, 1.0, lost=False, key=False)

        points = self._points(scan)
        information = step_information(tries[0], self.motion) if believed else guess_information(self.motion)
        match = self._refined(points, predicted, information)
        key = self._is_key(match.pose) or self._is_key(predicted)
        near = self._sees_less(scan, self.config.blocked_range)
        lost = self._sees_less(scan, 0.0) or (near and (believed or match.inliers < self.config.unsure_inliers))
        doubtful = self._doubtful(match, predicted, information, far=self._far(tries[0]))
        if lost or doubtful or (not believed and self._unsure(match)):
            refined = None if believed else match.pose
            place = self.chain.surroundings()
            match = searched(place, points, previous, tries, information, refined, self.config, self.matching)
            lost = lost or match.score < self.config.lost_score
        pose = predicted if lost else match.pose
        self._late = [*self._late, se2.between(previous, pose)][-self.motion.late_steps :]
        self._lost = self._lost + 1 if lost else 0
        key = key or self._is_key(pose) or (lost and self._begins_anew(scan, believed=believed))
        if key and lost and not (believed and near) and self._elsewhere(scan, predicted):
            self.chain.strays.append(len(self.chain.keys))
        if key:
            self._insert(scan, NOTHING if near and lost else points, pose, odometry, None if lost else match)
        else:
            self.chain.hang(pose)
        self._keep(scan, odometry)
        self._judge_wheels(odometry, None if lost else match)
        unfit = wheels is not None and not believed
        return Tracked(predicted, pose, match.score if key else match.inliers, lost, key, unfit)

    # -- steps of `track` --------------------------------------------------------------------------------------
    def _points(self, scan: LaserScan) -> PointSet:
        return point_set(scan, self.matching, self.segmentation)

    def _keep(self, scan: LaserScan, odometry: Float[np.ndarray, "3"] | None) -> None:
        """Remember the last scan as the one that the next ones are seen from."""
        self._looked_at, self._ranges = len(self.chain.anchors) - 1, scan.ranges
        self.wheels.at_scan(odometry)

    def _unchanged(self, scan: LaserScan) -> bool:
        """Whether a scan sees what the last matched one saw; frozen wheels do not show it when the robot moves."""
        if len(scan.ranges) != len(self._ranges):
            return False
        with np.errstate(invalid="ignore"):
            alike = np.abs(scan.ranges - self._ranges) < self.config.still_range
        return bool(np.mean(alike | (scan.ranges == self._ranges)) >= self.config.still_beams)

    def _unsure(self, match: Match) -> bool:
        """Whether a match leaves a direction open, or hardly half of the beams fit: to be searched for where no
        odometry helps."""
        weakest = np.linalg.eigvalsh(match.information[:2, :2])[0] * self.config.open_distance**2
        return bool(weakest < self.config.widening or match.inliers < self.config.unsure_inliers)

    def _judge_wheels(self, odometry: Float[np.ndarray, "3"] | None, match: Match | None) -> None:
        """Hold odometry against the poses of matched scans, one stretch of motion after the other."""
        (since, before), now = self.wheels.judged, len(self.chain.anchors) - 1
        if odometry is None or match is None or before is None:
            self.wheels.judged = (now, odometry)
            return
        made = se2.between(self.chain.pose_of(since), self.chain.pose_of(now))
        self.wheels.judge(now, odometry, made, turned(match.information / self.config.widening, -match.pose[2]))

    def _sees_less(self, scan: LaserScan, beyond: float) -> bool:
        """Whether hardly any beam comes back from farther than `beyond` (m)."""
        seen = np.count_nonzero((scan.ranges > max(scan.range_min, beyond)) & (scan.ranges < scan.range_max))
        return bool(seen < self.config.lost_beams * len(scan.ranges))

    def _begins_anew(self, scan: LaserScan, *, believed: bool) -> bool:
        """Whether a lost scan is to be what the next ones are matched to: where there is nothing else, or where many in
        a row were lost and no odometry tells of a way on."""
        waited = not believed and self._lost % self.config.patience == 0
        return (waited or self.chain.shows_nothing) and not self._sees_less(scan, self.config.blocked_range)

    def _elsewhere(self, scan: LaserScan, pose: Float[np.ndarray, "3"]) -> bool:
        """Whether a scan is not what it should be at `pose`, rather than of something new."""
        known, agreeing = compared(scan, self.chain.target().points, pose, self.matching.largest_range)
        return known > self.config.least_known and agreeing < self.config.least_agreeing * known

    def _still(self, step: Float[np.ndarray, "3"]) -> bool:
        return bool(np.hypot(step[0], step[1]) < self.config.still_distance and abs(step[2]) < self.config.still_turn)

    def _far(self, step: Float[np.ndarray, "3"]) -> bool:
        return bool(np.hypot(step[0], step[1]) > self.config.far_distance or abs(step[2]) > self.config.far_turn)

    def _is_key(self, pose: Float[np.ndarray, "3"]) -> bool:
        moved = se2.between(self.chain.poses[-1], pose)
        return bool(np.hypot(moved[0], moved[1]) > self.config.distance or abs(moved[2]) > self.config.turn)

    def _doubtful(
        self, match: Match, predicted: Float[np.ndarray, "3"], information: Float[np.ndarray, "3 3"], *, far: bool
    ) -> bool:
        """Whether a match without search lies too far from its prediction, or too few beams support it; more of them
        are asked for `far` from the last scan."""
        off = surprise(se2.between(predicted, match.pose), information)
        least = self.config.unsure_inliers if far else self.config.doubtful_inliers
        return off > self.config.surprise or match.inliers < least

    def _refined(self, points: PointSet, guess: Float[np.ndarray, "3"], information: Float[np.ndarray, "3 3"]) -> Match:
        return refine(
            self.chain.target(), points, guess, self.matching,
            prior_information=turned(information, guess[2]), gates=self.matching.tracking_gates,
        )  # fmt: skip

    def _insert(
        self,
        scan: LaserScan,
        points: PointSet,
        pose: Float[np.ndarray, "3"],
        odometry: Float[np.ndarray, "3"] | None,
        match: Match | None,
    ) -> None:
        """Make a key scan of a scan, tied to the one before by wheels and by its match, and learn from it."""
        moved, wheels = se2.between(self.chain.poses[-1], pose), self.wheels.key_step(odometry)
        extra = self.config.lost_travel if match is None else 0.0
        self.chain.extend(scan.index, points, pose, extra, self._factors(moved, wheels, match))
        if match is not None and wheels is not None:
            self.wheels.learn(wheels, moved, self.config.wheel_gate)
        self.wheels.at_key(odometry)

    def _factors(
        self, moved: Float[np.ndarray, "3"], wheels: Float[np.ndarray, "3"] | None, match: Match | None
    ) -> list[PoseFactor]:
        """What wheels and beams each say about the step from the last key scan, wheels as long as they fit; where
        beams leave it open and wheels do not speak, only that it was a step."""
        i, j = len(self.chain.keys) - 1, len(self.chain.keys)
        out = []
        if wheels is not None and self.wheels.fit:
            step = self.wheels.unbiased(wheels)
            information = step_information(step, self.motion)
            if match is None or surprise(se2.between(step, moved), information) < self.config.wheel_gate:
                out.append(PoseFactor(i, j, step, square_root(information), "odometry"))
        told = np.zeros((3, 3)) if match is None else matched_information(match, self.config)
        if match is not None:
            out.append(PoseFactor(i, j, moved, square_root(told), "matching"))
        least = np.diag(1.0 / np.square(self.config.lost_step))
        if not (out and out[0].kind == "odometry") and np.linalg.eigvalsh(told - least)[0] < 0.0:
            out.insert(0, PoseFactor(i, j, moved, square_root(least), "odometry"))
        return out
