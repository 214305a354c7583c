"""Where each scan lies relative to the last key scans: predict, search, refine, and decide whether it becomes a
key scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.front_end.contradiction import compared
from bspline_slam.front_end.motion import (
    MotionConfig,
    OdometryCalibration,
    Unexplained,
    guess_information,
    guesses,
    step_information,
    surprise,
)
from bspline_slam.front_end.rows import Rows
from bspline_slam.front_end.scan_matching import (
    Match,
    MatchingConfig,
    PointSet,
    Surroundings,
    Target,
    correlation,
    gather,
    point_set,
    refine,
    search,
    settle,
    surroundings,
)
from bspline_slam.graph import PoseFactor, square_root
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import SegmentationConfig


@dataclass(frozen=True, slots=True)
class TrackingConfig:
    """When a scan becomes a key scan (m, rad), what it is matched to, and when its match is not believed.

    `local_scans` make the local map. A scan stands still, and is not matched, when odometry says so since the last
    matched one and at least `still_beams` of its ranges are within `still_range` (m) of that one's. A scan is searched
    for, not only refined, when fewer than `doubtful_inliers` of its beams fit, `unsure_inliers` where it lies `far_…`
    from the last one, or when the squared Mahalanobis distance to its prediction exceeds `surprise`; where no odometry
    is to be believed also when a direction is left open by more than `open_distance` (m, 1 σ) or fewer than
    `unsure_inliers` fit.
    Below a correlation of `lost_score`, or when less than `lost_beams` of its beams
    come back, a scan is lost and odometry is taken instead. When less than that see beyond `blocked_range` (m),
    somebody may stand before the laser, which fits anywhere: then a scan is lost too, unless there is no odometry to be
    believed and it fits where it is expected; and nothing is ever matched to it.
    `widening` multiplies the information of a match and `floor` adds to its standard deviations: neighbouring
    matches share their errors. A key scan that neither beams nor odometry tie to the one before, in any direction, lies
    within `lost_step` (m, m, rad; 1 σ) of it, and `lost_travel` is how far (m) each lost key scan counts as travelled;
    `untied` (m, rad; 1 σ) is between two of which neither knows of the other. A lost scan is taken to be of another
    place when walls were expected in `least_known` of the sectors in which its beams end, and it sees less than
    `least_agreeing` of them.
    """

    distance: float = 0.5
    turn: float = np.deg2rad(20.0)
    local_scans: int = 12
    still_distance: float = 0.01
    still_turn: float = np.deg2rad(0.3)
    still_range: float = 0.05
    still_beams: float = 0.7
    far_distance: float = 0.35
    far_turn: float = np.deg2rad(15.0)
    good_score: float = 0.6
    lost_score: float = 0.3
    lost_beams: float = 0.1
    blocked_range: float = 0.6
    doubtful_inliers: float = 0.5
    surprise: float = 9.0
    open_distance: float = 0.03
    unsure_inliers: float = 0.7
    widening: float = 9.0
    wheel_gate: float = 25.0
    floor: tuple[float, float, float] = (0.007, 0.007, 0.003)
    lost_step: tuple[float, float, float] = (1.0, 1.0, 0.5)
    lost_travel: float = 10.0
    least_known: float = 0.5
    least_agreeing: float = 0.35
    untied: float = 1e3


MARGIN = 0.05
"""By so much (correlation) a less likely guess must do better than a more likely one."""
ALIKE = 0.25
"""Search windows that lie apart by less than this share of their reach find the same."""
NOTHING = PointSet(np.zeros((0, 2)), np.zeros((0, 2)))
"""What a blocked scan shows of the world."""


@dataclass(frozen=True, eq=False, slots=True)
class KeyScan:
    """A scan that entered the problem: its index in the log and its beam ends."""

    scan: int
    points: PointSet
    travel: float


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
    """State of tracking: the key scans and their poses, and every other scan tied to one of them.

    `key_poses` may be replaced from outside (loop closures, adjustment); everything else hangs on them: `anchors`
    ties each scan to the key scan before it, `moves` each key scan to the one before, as tracking saw them. `strays`
    are the key scans (by number) that were lost and see another place than they should: whatever ties them to the one
    before is in doubt.
    """

    config: TrackingConfig
    matching: MatchingConfig
    segmentation: SegmentationConfig
    motion: MotionConfig
    keys: list[KeyScan] = field(default_factory=list)
    key_poses: Rows = field(default_factory=Rows)
    anchors: list[tuple[int, Float[np.ndarray, "3"]]] = field(default_factory=list)
    moves: list[Float[np.ndarray, "3"]] = field(default_factory=list)
    factors: list[PoseFactor] = field(default_factory=list)
    calibration: OdometryCalibration = field(default_factory=OdometryCalibration)
    unexplained: Unexplained = field(init=False)
    strays: list[int] = field(default_factory=list)
    _judged: tuple[int, Float[np.ndarray, "3"] | None] = (0, None)
    _unbiased: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    _matched: int = 0
    _ranges: Float[np.ndarray, "beams"] = field(default_factory=lambda: np.zeros(0))
    _odometry: Float[np.ndarray, "3"] | None = None
    _key_odometry: Float[np.ndarray, "3"] | None = None
    _late: list[Float[np.ndarray, "3"]] = field(default_factory=list)
    _target: Target | None = None
    _surroundings: Surroundings | None = None

    def __post_init__(self) -> None:
        self.unexplained = Unexplained.at_start(self.motion)

    def assume(self, signs: tuple[float, float, float]) -> None:
        """Take odometry (dx, dy, dθ) with these signs until there is something better to learn from."""
        self._calibrate(replace(self.calibration, signs=signs))

    def track(self, scan: LaserScan, odometry: Float[np.ndarray, "3"] | None) -> Tracked:
        """Place the next scan of the log; `odometry` is its odometry pose, None where the log has none."""
        if not self.keys:
            self._insert(scan, point_set(scan, self.matching, self.segmentation), se2.IDENTITY, odometry, None)
            self._keep(scan, odometry)
            return Tracked(se2.IDENTITY, se2.IDENTITY, 1.0, lost=False, key=True)

        previous = self._tracked(self._matched)
        wheels = None if odometry is None or self._odometry is None else se2.between(self._odometry, odometry)
        believed = wheels is not None and self.unexplained.fits
        steps = None if wheels is None else (self._unbiased @ wheels, wheels)
        tries = guesses(steps, self._late, self.motion, believed=believed)
        predicted = se2.compose(previous, tries[0])
        if wheels is not None and believed and self._still(wheels) and self._unchanged(scan):
            self.anchors.append((len(self.keys) - 1, se2.between(self.key_poses[-1], predicted)))
            return Tracked(predicted, predicted, 1.0, lost=False, key=False)

        points = point_set(scan, self.matching, self.segmentation)
        information = step_information(tries[0], self.motion) if believed else guess_information(self.motion)
        match = self._refined(points, predicted, information)
        key = self._is_key(match.pose) or self._is_key(predicted)
        near = self._sees_less(scan, self.config.blocked_range)
        lost = self._sees_less(scan, 0.0) or (near and (believed or match.inliers < self.config.unsure_inliers))
        doubtful = self._doubtful(match, predicted, information, far=self._far(tries[0]))
        if lost or doubtful or (not believed and self._unsure(match)):
            match = self._searched(points, previous, tries, information, None if believed else match.pose)
            lost = lost or match.score < self.config.lost_score
        pose = predicted if lost else match.pose
        self._late = [*self._late, se2.between(previous, pose)][-self.motion.late_steps :]
        key = key or self._is_key(pose)
        if key and lost and not (believed and near) and self._elsewhere(scan, predicted):
            self.strays.append(len(self.keys))
        if key:
            self._insert(scan, NOTHING if near and lost else points, pose, odometry, None if lost else match)
        else:
            self.anchors.append((len(self.keys) - 1, se2.between(self.key_poses[-1], pose)))
        self._keep(scan, odometry)
        self._judge_wheels(odometry, None if lost else match)
        unfit = wheels is not None and not believed
        return Tracked(predicted, pose, match.score if key else match.inliers, lost, key, unfit)

    @property
    def poses(self) -> Float[np.ndarray, "scans 3"]:
        """World poses of all scans so far."""
        if not self.anchors:
            return np.zeros((0, 3))
        chain = [np.zeros(3)]
        for moved in self.moves:
            chain.append(se2.compose(chain[-1], moved))
        before = np.array(chain)
        anchor = np.array([anchor for anchor, _ in self.anchors])
        scans = se2.compose(before[anchor], np.array([relative for _, relative in self.anchors]))
        return carried_along(scans, np.array([key.scan for key in self.keys]), before, np.array(self.key_poses))

    def local_target(self) -> Target:
        """The last key scans as one target."""
        if self._target is None:
            n = self.config.local_scans
            self._target = gather([key.points for key in self.keys[-n:]], self.key_poses[-n:])
        return self._target

    def move(self, key_poses: Float[np.ndarray, "n 3"]) -> None:
        """Take over corrected poses of the key scans."""
        self.key_poses = Rows(key_poses)
        self._target = self._surroundings = None

    def untie(self, since: int, where: PoseFactor) -> None:
        """Let go of what ties key scan `since` to the one before, and carry all from it on to where a closure puts
        one of them."""
        poses = np.array(self.key_poses)
        there = se2.compose(poses[where.i], where.measured)
        poses[since:] = se2.compose(se2.compose(there, se2.inverse(poses[where.j])), poses[since:])
        loose = np.eye(3) / self.config.untied
        moved = se2.between(poses[since - 1], poses[since])
        self.factors = [factor for factor in self.factors if factor.j != since]
        self.factors.append(PoseFactor(since - 1, since, moved, loose, "odometry"))
        self.move(poses)

    # -- steps of `track` --------------------------------------------------------------------------------------
    def _tracked(self, scan: int) -> Float[np.ndarray, "3"]:
        """World pose of a scan (by its number among those tracked), tied to the key scan before it."""
        anchor, relative = self.anchors[scan]
        return se2.compose(self.key_poses[anchor], relative)

    def _keep(self, scan: LaserScan, odometry: Float[np.ndarray, "3"] | None) -> None:
        """Remember the last scan as the one that the next ones are seen from."""
        self._matched, self._ranges, self._odometry = len(self.anchors) - 1, scan.ranges, odometry

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
        (since, before), now = self._judged, len(self.anchors) - 1
        if odometry is None or match is None or before is None:
            self._judged = (now, odometry)
            return
        made = se2.between(self._tracked(since), self._tracked(now))
        wheels = self._unbiased @ se2.between(before, odometry)
        if self._counts(made) or self._counts(wheels):
            seen = turned(match.information / self.config.widening, -match.pose[2])
            self.unexplained = self.unexplained.learned(wheels, made, seen, self.motion)
            self._judged = (now, odometry)
            if not self.unexplained.fits:
                self._calibrate(replace(self.calibration, distrusted=True))

    def _calibrate(self, calibration: OdometryCalibration) -> None:
        self.calibration, self._unbiased = calibration, calibration.matrix(self.motion)

    def _counts(self, step: Float[np.ndarray, "3"]) -> bool:
        return bool(np.hypot(step[0], step[1]) > self.motion.judged_distance or abs(step[2]) > self.motion.judged_turn)

    def _sees_less(self, scan: LaserScan, beyond: float) -> bool:
        """Whether hardly any beam comes back from farther than `beyond` (m)."""
        seen = np.count_nonzero((scan.ranges > max(scan.range_min, beyond)) & (scan.ranges < scan.range_max))
        return bool(seen < self.config.lost_beams * len(scan.ranges))

    def _elsewhere(self, scan: LaserScan, pose: Float[np.ndarray, "3"]) -> bool:
        """Whether a scan is not what it should be at `pose`, rather than of something new."""
        known, agreeing = compared(scan, self.local_target().points, pose, self.matching.largest_range)
        return known > self.config.least_known and agreeing < self.config.least_agreeing * known

    def _still(self, step: Float[np.ndarray, "3"]) -> bool:
        return bool(np.hypot(step[0], step[1]) < self.config.still_distance and abs(step[2]) < self.config.still_turn)

    def _far(self, step: Float[np.ndarray, "3"]) -> bool:
        return bool(np.hypot(step[0], step[1]) > self.config.far_distance or abs(step[2]) > self.config.far_turn)

    def _is_key(self, pose: Float[np.ndarray, "3"]) -> bool:
        moved = se2.between(self.key_poses[-1], pose)
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
            self.local_target(), points, guess, self.matching,
            prior_information=turned(information, guess[2]), gates=self.matching.tracking_gates,
        )  # fmt: skip

    def _searched(
        self,
        points: PointSet,
        previous: Float[np.ndarray, "3"],
        tries: tuple[Float[np.ndarray, "3"], ...],
        information: Float[np.ndarray, "3 3"],
        refined: Float[np.ndarray, "3"] | None,
    ) -> Match:
        """The best of searches around each guess of the step. Where no odometry tells of it, in a wider window, and
        wider still when nothing good is found; what is found must then do better than the pose `refined` without a
        search, for along a bare wall all poses are as good. What contradicts odometry that is believed counts only
        where the scan were lost without it, for the last place is known better than the next."""
        if self._surroundings is None:
            self._surroundings = surroundings(self.local_target(), self.matching)
        place, config, good, unknown = self._surroundings, self.matching, self.config.good_score, refined is not None
        reach, turn = (config.wide_reach, config.wide_turn) if unknown else (config.reach, config.turn)
        best, guess, best_score = previous, previous, -1.0
        if refined is not None:
            best, best_score = refined, correlation(place.field, points, refined, config)
        for step in apart(tries, reach, turn):
            start = se2.compose(previous, step)
            found, score = search(place.field, points, start, config, reach, turn)
            against = not unknown and surprise(se2.between(tries[0], step), information) > self.config.wheel_gate
            if against and (best_score > self.config.lost_score or score < good):
                continue
            if score > best_score + MARGIN:
                best, guess, best_score = found, start, score
            if best_score > good and not unknown:
                break
        if unknown and best_score < good:
            found, score = search(place.field, points, previous, config, config.widest_reach, config.widest_turn)
            best, best_score = (found, score) if score > best_score + 2.0 * MARGIN else (best, best_score)
        held = best if unknown else guess
        return settle(place, points, best, best_score, config, held, turned(information, best[2]))

    def _insert(
        self,
        scan: LaserScan,
        points: PointSet,
        pose: Float[np.ndarray, "3"],
        odometry: Float[np.ndarray, "3"] | None,
        match: Match | None,
    ) -> None:
        travel = 0.0
        if self.keys:
            moved = se2.between(self.key_poses[-1], pose)
            travel = self.keys[-1].travel + float(np.hypot(moved[0], moved[1]))
            travel += self.config.lost_travel if match is None else 0.0
            wheels = None
            if odometry is not None and self._key_odometry is not None:
                wheels = se2.between(self._key_odometry, odometry)
            self.moves.append(moved)
            self.factors.extend(self._factors(moved, wheels, match))
            if match is not None and wheels is not None and self._fit(wheels, moved):
                self._calibrate(self.calibration.learned(wheels, moved, self.motion))
        self.keys.append(KeyScan(scan.index, points, travel))
        self.key_poses.append(pose)
        self.anchors.append((len(self.keys) - 1, np.zeros(3)))
        self._key_odometry = odometry
        self._target = self._surroundings = None

    def _fit(self, wheels: Float[np.ndarray, "3"], moved: Float[np.ndarray, "3"]) -> bool:
        """Whether a matched step tells of the bias of odometry, and not of a wrong match or of wheels that slipped."""
        if not self.unexplained.fits:
            return True
        information = step_information(wheels, self.motion)
        off = (surprise(se2.between(step, moved), information) for step in (self._unbiased @ wheels, wheels))
        return min(off) < self.config.wheel_gate

    def _factors(
        self, moved: Float[np.ndarray, "3"], wheels: Float[np.ndarray, "3"] | None, match: Match | None
    ) -> list[PoseFactor]:
        """What wheels and beams each say about the step from the last key scan, wheels as long as they fit; where
        beams leave it open and wheels do not speak, only that it was a step."""
        i, j = len(self.keys) - 1, len(self.keys)
        out = []
        if wheels is not None and self.unexplained.fits:
            step = self._unbiased @ wheels
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


def apart(steps: Sequence[Float[np.ndarray, "3"]], reach: float, turn: float) -> list[Float[np.ndarray, "3"]]:
    """Only those steps whose search windows are not much the same as that of an earlier one."""
    chosen: list[Float[np.ndarray, "3"]] = []
    for step in steps:
        off = [np.abs(step - other) / (reach, reach, turn) for other in chosen]
        if all(away.max() > ALIKE for away in off):
            chosen.append(step)
    return chosen


def turned(information: Float[np.ndarray, "3 3"], heading: float) -> Float[np.ndarray, "3 3"]:
    """An information matrix of a pose with the frame of its position turned by `heading`."""
    turn = np.eye(3)
    turn[:2, :2] = se2.rotation(heading)
    return turn @ information @ turn.T


def carried_along(
    poses: Float[np.ndarray, "scans 3"],
    key_scans: Int[np.ndarray, "n"],
    before: Float[np.ndarray, "n 3"],
    after: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, "scans 3"]:
    """Poses of all scans after their key scans moved from `before` to `after`.

    Each goes along with the key scans on both sides of it, the difference spread evenly over the scans between them.
    """
    index = np.arange(len(poses))
    left = np.clip(np.searchsorted(key_scans, index, side="right") - 1, 0, None)
    right = np.minimum(left + 1, len(key_scans) - 1)
    with_left = se2.compose(after[left], se2.between(before[left], poses))
    with_right = se2.compose(after[right], se2.between(before[right], poses))
    gap = np.maximum(key_scans[right] - key_scans[left], 1)
    return se2.interpolate(with_left, with_right, np.where(right > left, (index - key_scans[left]) / gap, 0.0))


def matched_information(match: Match, config: TrackingConfig) -> Float[np.ndarray, "3 3"]:
    """Information (wΛ⁻¹ + F)⁻¹ of a match in the frame of its own pose (the frame of PoseFactor residuals).

    Λ is the information of the beams, w `widening` and F the squared `floor`; written so that Λ may be singular.
    """
    root = square_root(turned(match.information, -match.pose[2]))
    floor = np.diag(np.square(config.floor))
    return root.T @ np.linalg.inv(config.widening * np.eye(3) + root @ floor @ root.T) @ root
