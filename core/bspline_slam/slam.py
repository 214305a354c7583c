"""The pipeline: from a log to a map, one scan at a time; what it saw and decided is recorded as frozen steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.adjustment.adjust import AdjustmentConfig, Foreseen, adjust_splines, foreseen
from bspline_slam.association import Association, AssociationConfig
from bspline_slam.backends import BACK_ENDS, Stopping, back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, Marginals, never
from bspline_slam.backends.threads import in_one_thread
from bspline_slam.calibration.laser import LaserCalibration, laser_calibration
from bspline_slam.calibration.laser_correction import LaserCorrection
from bspline_slam.calibration.odometry_noise import with_learnt_noise
from bspline_slam.calibration.velocities import velocities
from bspline_slam.errors import Cancelled, ConfigError, LogError, SolverError
from bspline_slam.fitting import FittingConfig
from bspline_slam.front_end.far_loops import FarCloser, FarLoopConfig
from bspline_slam.front_end.loop_closure import LoopCloser, LoopClosure, LoopConfig, Proposal
from bspline_slam.front_end.mapping import MapBuilder
from bspline_slam.front_end.motion import MotionConfig
from bspline_slam.front_end.odometry_signs import odometry_signs
from bspline_slam.front_end.relocalisation import RelocalisationConfig, Relocaliser
from bspline_slam.front_end.scan_matching import MatchingConfig
from bspline_slam.front_end.tracking import Tracker, TrackingConfig, carried_along
from bspline_slam.graph import Graph, PoseFactor, PosePrior
from bspline_slam.localisation import LocalisationConfig, place_on_curves
from bspline_slam.models import ChordLengthConfig, make_model
from bspline_slam.models.protocol import Model
from bspline_slam.observation import MODELS
from bspline_slam.scan import LaserScan, ScanLog
from bspline_slam.segmentation import ScanSegment, SegmentationConfig, segment_scan
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.merging import MergingConfig
from bspline_slam.tidying.tidy_map import tidied


@dataclass(frozen=True, slots=True)
class SlamConfig:
    """Everything that can be tuned, stage by stage; the defaults serve every log.

    `model` says what an observation of a spline is, and so of what kind its curves are: its order is `fitting.degree`
    + 1, its knots `fitting.spacing` apart with "normal-distance", its control points `chord_length.control_points` in
    number with "chord-length". `back_end` solves the adjustment. Splines seen by fewer than `least_observations` key
    scans leave the finished map. The map goes along when a loop closure has moved a key scan by more than
    `rebuild_move` (m).
    """

    back_end: str = "direct"
    model: str = MODELS[0]
    segmentation: SegmentationConfig = SegmentationConfig()
    matching: MatchingConfig = MatchingConfig()
    motion: MotionConfig = MotionConfig()
    tracking: TrackingConfig = TrackingConfig()
    association: AssociationConfig = AssociationConfig()
    fitting: FittingConfig = FittingConfig()
    chord_length: ChordLengthConfig = ChordLengthConfig()
    loops: LoopConfig = LoopConfig()
    far_loops: FarLoopConfig = FarLoopConfig()
    relocalisation: RelocalisationConfig = RelocalisationConfig()
    merging: MergingConfig = MergingConfig()
    adjustment: AdjustmentConfig = AdjustmentConfig()
    localisation: LocalisationConfig = LocalisationConfig()
    least_observations: int = 3
    rebuild_move: float = 0.1


def model_of(config: SlamConfig) -> Model:
    """The observation model that a configuration asks for. Raises ConfigError for one that does not exist."""
    return make_model(config.model, config.fitting, config.chord_length)


def check_names(config: SlamConfig) -> None:
    """Raises ConfigError for a back end, a model or curves that do not exist, before any work is done."""
    if config.back_end not in BACK_ENDS:
        raise ConfigError(f'there is no back end "{config.back_end}": choose one of {", ".join(BACK_ENDS)}')
    model_of(config)


@dataclass(frozen=True, eq=False, slots=True)
class SlamStep:
    """What was done with one scan.

    `predicted` is the pose before the scan was looked at, `pose` after (world frame). `key` says whether the scan
    entered the map; only key scans carry segments, associations and loop closures. `score` (0…1) is the matcher's
    correlation and `lost` that it was too low to be believed; `unfit` that odometry was not believed, for it did not
    fit what scans show.
    """

    scan: int
    predicted: Float[np.ndarray, "3"]
    pose: Float[np.ndarray, "3"]
    key: bool
    lost: bool
    score: float
    segments: tuple[ScanSegment, ...] = ()
    associations: tuple[Association, ...] = ()
    loop_closures: tuple[LoopClosure, ...] = ()
    unfit: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """The whole estimate at one moment: poses of the scans read so far, the map, and the decisions behind it.

    `poses[i]` is the pose of scan i (world frame); `steps` holds the latest SlamStep of each *key* scan, with poses
    as estimated now, and `observations` the same as the adjustment reads them. `pose_factors` tie key scans by
    odometry, matching and loop closures. `laser` is what the segments of a finished estimate are corrected by.
    """

    poses: Float[np.ndarray, "scans 3"]
    key_scans: Int[np.ndarray, "n"]
    steps: tuple[SlamStep, ...]
    map: SplineMap
    loop_closures: tuple[LoopClosure, ...]
    estimate: Estimate | None = None
    observations: tuple[KeyObservations, ...] = ()
    pose_factors: tuple[PoseFactor, ...] = ()
    laser: LaserCalibration = LaserCalibration()


@dataclass(frozen=True, eq=False, slots=True)
class SlamResult:
    """A finished run: the estimate, wall seconds by stage, and the scans (by index) that were lost on the way or whose
    odometry was `unfit`, not believed because it did not fit what scans show."""

    snapshot: Snapshot
    seconds: dict[str, float]
    lost: tuple[int, ...] = ()
    unfit: tuple[int, ...] = ()


RELAXED_AFTER, RELAXED_SHARE = 5, 0.1
"""So many closures, and such a share of all so far, make the pose graph be solved anew though each of them says what
the estimate says already: together they say more, and the more there are the less does one of them."""

StageProgress = Callable[[str, float, IterationRecord | None], None]


def quiet(stage: str, fraction: float, record: IterationRecord | None) -> None:
    """Progress that nobody watches."""


@dataclass
class Slam:
    """B-spline SLAM over a log. State: the tracker, the loop closer, the map builder, and the decisions so far."""

    log: ScanLog
    config: SlamConfig = field(default_factory=SlamConfig)
    cancelled: Cancelling = never
    _model: Model = field(init=False)
    _tracker: Tracker = field(init=False)
    _closer: LoopCloser = field(init=False)
    _far: FarCloser = field(init=False)
    _builder: MapBuilder = field(init=False)
    _seeker: Relocaliser | None = None
    _steps: list[SlamStep] = field(default_factory=list)
    _observations: list[KeyObservations] = field(default_factory=list)
    _estimate: Estimate | None = None
    _solved_with: int = 0
    _laser: LaserCalibration = LaserCalibration()

    def __post_init__(self) -> None:
        c = self.config
        check_names(c)
        self._model = model_of(c)
        self._tracker = self._new_tracker()
        self._closer = LoopCloser(c.loops, c.matching, c.tracking)
        self._far = FarCloser(c.far_loops, c.matching, c.tracking, c.loops)
        self._builder = MapBuilder(c.association, self._model)

    def steps(self) -> Iterator[SlamStep]:
        """Process the log in its order, one step per scan. Raises Cancelled between scans."""
        if len(self.log) == 0:
            raise LogError(self.log.path, "it holds no laser scan, so there is nothing to map")
        odometry = self.log.odometry
        if odometry is not None:
            self._tracker.assume(odometry_signs(self.log, odometry, self._new_tracker))
        for scan in self.log:
            if self.cancelled():
                raise Cancelled(f"cancelled at scan {scan.index}")
            yield self.process(scan, None if odometry is None else odometry[scan.index])

    def process(self, scan: LaserScan, odometry: Float[np.ndarray, "3"] | None) -> SlamStep:
        """One scan: track it; if it is a key scan, close loops, cut it into segments, associate them, grow the
        map."""
        tracked = self._tracker.track(scan, odometry)
        if not tracked.key:
            step = SlamStep(scan.index, tracked.predicted, tracked.pose, False, tracked.lost, tracked.score)
            return replace(step, unfit=tracked.unfit)
        closures = (*self._find_again(), *self._close_far(), *self._close_loops())
        segments = segment_scan(scan, self.config.segmentation)
        pose = self._tracker.key_poses[-1]
        sensor = scan.pose_robot_sensor[:2]
        associations = () if tracked.lost else self._builder.add(scan.index, pose, segments, sensor)
        step = SlamStep(
            scan.index, tracked.predicted, pose, True, tracked.lost, tracked.score, segments, associations, closures,
            tracked.unfit,
        )  # fmt: skip
        self._steps.append(step)
        beams = int(np.count_nonzero(scan.valid))
        self._observations.append(KeyObservations(scan.index, segments, associations, beams, sensor))
        return step

    def snapshot(self) -> Snapshot:
        """The estimate as it stands."""
        return self._snapshot(self._builder.map, self._current_observations())

    def finish(self, progress: StageProgress = quiet, cancelled: Cancelling = never) -> Snapshot:
        """Solve the pose graph, build the map anew about where adjustment is going to put the key scans, make each
        wall one spline, adjust everything. Loop closures that turn out to be wrong on the way are taken back. Raises
        Cancelled."""
        progress("pose graph", 0.0, None)
        self._closer.found(self._tracker.keys, np.array(self._tracker.key_poses))
        self._relax()
        if self._closer.reject_contradicted(np.array(self._tracker.key_poses)):
            self._relax()
        correction = self._correct(cancelled)
        self._rebuild()
        keys, tidy = self._tidied()
        splines, estimate = self._adjusted(keys, tidy, progress, cancelled)
        if self._closer.reject_contradicted(estimate.poses):
            splines, estimate = self._adjusted(keys, tidy, progress, cancelled)
        self._tracker.move(estimate.poses)
        self._estimate = estimate
        snapshot = self._snapshot(splines, keys)
        c = self.config
        poses = place_on_curves(
            self.log, snapshot.poses, snapshot.key_scans, splines, c.localisation, c.matching, c.segmentation,
            correction.scan, lambda fraction: progress("scans between", fraction, None), cancelled,
        )  # fmt: skip
        return replace(snapshot, poses=poses)

    def _new_tracker(self) -> Tracker:
        c = self.config
        return Tracker(c.tracking, c.matching, c.segmentation, c.motion)

    # -- steps of `process` and `finish` -----------------------------------------------------------------------
    def _close_loops(self) -> tuple[LoopClosure, ...]:
        """Relax the pose graph where the key scan before this one closed a loop and closures say that it should move;
        begin to compare this one with earlier places. Returns what was decided."""
        keys, poses = self._tracker.keys, np.array(self._tracker.key_poses)
        before, closed_at = len(self._closer.closures), self._closer.closed_at
        fresh = self._closer.found(keys, poses)
        self._solved_with += len(fresh)
        enough = max(RELAXED_AFTER, RELAXED_SHARE * len(self._closer.accepted))
        if fresh and (self._disagree(fresh, poses) or self._solved_with >= enough):
            self._relax()
            moved = self._tracker.key_poses[:-1][:, :2] - poses[:-1, :2]
            if np.abs(moved).max(initial=0.0) > self.config.rebuild_move:
                self._carry(poses, closed_at)
        self._closer.look(keys, np.array(self._tracker.key_poses))
        return tuple(self._closer.closures[before:])

    def _close_far(self) -> tuple[LoopClosure, ...]:
        """Where the last key scans fit only one place inside an uncertainty too large for a search around them: close
        the loop there, at first whatever stands against it, and let the map go along."""
        keys, poses, closed_at = self._tracker.keys, np.array(self._tracker.key_poses), self._closer.closed_at
        fresh = self._far.look(keys, poses, self._tracker.factors, self._closer)
        if fresh:
            self._relax(tuple(replace(proposal.factor, kernel=None) for proposal in fresh))
            self._closer.accept(fresh, keys)
            self._relax()
            self._carry(poses, closed_at)
        return tuple(proposal.closure for proposal in fresh)

    def _find_again(self) -> tuple[LoopClosure, ...]:
        """Where the tie of the last key scans to those before is in doubt: look for them on the whole map; when they
        are found elsewhere, the piece goes there, and the map is read anew."""
        tracker, c = self._tracker, self.config
        if tracker.strays and (self._seeker is None or self._seeker.since < tracker.strays[-1]):
            self._seeker = Relocaliser(tracker.strays[-1], c.relocalisation, c.matching, c.tracking, c.loops)
        if self._seeker is None or self._seeker.settled:
            return ()
        fresh = self._seeker.look(tracker.keys, np.array(tracker.key_poses), tracker.strays)
        if fresh:
            self._closer.take(fresh, tracker.keys, self._seeker.since)
            if self._disagree(fresh, np.array(tracker.key_poses)):
                tracker.untie(self._seeker.since, fresh[-1].factor)
                self._relax()
                self._rebuild()
        return tuple(proposal.closure for proposal in fresh)

    def _carry(self, before: Float[np.ndarray, "n 3"], closed_at: float) -> None:
        """The map goes along with its key scans; those since the last closure (m travelled) are read anew, for they
        drew again what was there."""
        after, n = np.array(self._tracker.key_poses), len(self._steps)
        scans = np.array([step.scan for step in self._steps], dtype=np.int64)
        self._builder.carry(scans, before[:n], after[:n])
        self._steps = [replace(step, pose=pose) for step, pose in zip(self._steps, after, strict=False)]
        since = next((k for k in range(n) if self._tracker.keys[k].travel > closed_at), n)
        if since < n:
            self._builder.inherited = self._inheritance()
            self._builder.forget(self._steps[since].scan)
            self._read(range(since, n))

    def _disagree(self, fresh: Sequence[Proposal], poses: Float[np.ndarray, "n 3"]) -> bool:
        """Whether a closure lies off the present estimate by more than the map's own tolerance."""
        for p in fresh:
            off = se2.between(p.closure.measured, se2.between(poses[p.i], poses[p.j]))
            if np.hypot(off[0], off[1]) > self.config.rebuild_move:
                return True
        return False

    def _relax(self, more: Sequence[PoseFactor] = ()) -> None:
        """The pose graph solved with all factors so far, and `more`."""
        if len(self._tracker.keys) < 2:
            return
        self._solved_with = 0
        poses = np.array(self._tracker.key_poses)
        graph = Graph(
            key_scans=np.array([key.scan for key in self._tracker.keys], dtype=np.int64),
            poses=poses,
            spline_ids=np.zeros(0, dtype=np.int64),
            spline_first=np.zeros(1, dtype=np.int64),
            control_points=np.zeros((0, 2)),
            pose_factors=(*self._pose_factors(), *more),
            pose_priors=(PosePrior(0, poses[0], np.eye(3) / self.config.adjustment.anchor),),
        )
        self._tracker.move(back_end("pose_graph", Stopping(1e-5, 1e-4, 20)).solve(graph).poses)

    def _pose_factors(self) -> tuple[PoseFactor, ...]:
        return (*self._tracker.factors, *(proposal.factor for proposal in self._closer.accepted))

    def _rebuild(self) -> None:
        """The map built anew at the present poses; splines keep the ids of those that the same segments began."""
        c = self.config
        self._builder = MapBuilder(c.association, self._model, self._inheritance(), first_id=self._builder.next_id)
        self._read(range(len(self._steps)))

    def _inheritance(self) -> Callable[[int, int], int]:
        """Which spline a segment belonged to: that which it begins when it is read anew takes this id again."""
        inherited: dict[tuple[int, int], int] = {}
        for step in self._steps:
            for association in step.associations:
                if association.spline is not None:
                    inherited.setdefault((step.scan, association.segment), self._builder.heir(association.spline))
        return lambda scan, segment: inherited.get((scan, segment), -1)

    def _read(self, keys: Iterable[int]) -> None:
        """Associate the segments of key scans anew, at their present poses."""
        for k in keys:
            step, pose, sensor = self._steps[k], self._tracker.key_poses[k], self._observations[k].sensor
            associations = () if step.lost else self._builder.add(step.scan, pose, step.segments, sensor)
            self._steps[k] = replace(step, associations=associations, pose=pose)
            self._observations[k] = replace(self._observations[k], associations=associations)

    def _correct(self, cancelled: Cancelling) -> LaserCorrection:
        """Put key scans about where the adjustment is going to put them; weigh odometry by how well it tells that, and
        correct their beams by what of their errors is the laser's."""
        c = self.config
        told = foreseen(
            self._current_observations(), np.array(self._tracker.key_poses), self._worthy(self._builder.map),
            self._pose_factors(), c.adjustment, self._model, c.back_end, cancelled,
        )  # fmt: skip
        self._tracker.move(told.estimate.poses)
        self._tracker.factors = with_learnt_noise(self._tracker.factors, told.estimate.poses, c.motion)
        correction = self._laser_correction(told)
        self._laser = correction.calibration
        self._steps = [
            replace(step, segments=correction.segments(step.segments, key.sensor))
            for step, key in zip(self._steps, self._observations, strict=True)
        ]
        self._observations = [
            replace(key, segments=step.segments) for step, key in zip(self._steps, self._observations, strict=True)
        ]
        return correction

    def _laser_correction(self, told: Foreseen) -> LaserCorrection:
        """What a rough estimate tells of the laser; nothing where the model measures along curves, too."""
        beams = len(self.log[0].ranges)
        if self._model.measures_along:
            return LaserCorrection(LaserCalibration(), np.zeros((0, 3)), beams)
        velocity = velocities(self.log.records, self._tracker.poses)
        keys = velocity[told.estimate.graph.key_scans]
        laser = laser_calibration(told, self.config.adjustment.outlier, self._model.fitting, beams, keys)
        return LaserCorrection(laser, velocity, beams)

    def _tidied(self) -> tuple[tuple[KeyObservations, ...], SplineMap]:
        """The decisions and the map to adjust, each wall one spline."""
        c, poses = self.config, np.array(self._tracker.key_poses)
        splines = self._worthy(self._builder.map)
        keys, splines = tidied(self._current_observations(), poses, splines, c.merging, c.adjustment, self._model)
        return keys, self._worthy(splines)

    def _adjusted(
        self, keys: Sequence[KeyObservations], splines: SplineMap, progress: StageProgress, cancelled: Cancelling
    ) -> tuple[SplineMap, Estimate]:
        c = self.config
        return adjust_splines(
            keys, np.array(self._tracker.key_poses), splines, self._pose_factors(), c.adjustment, self._model,
            c.back_end,
            lambda fraction, record: progress("adjustment", fraction, record), cancelled,
        )  # fmt: skip

    def _worthy(self, splines: SplineMap) -> SplineMap:
        """The splines that enough key scans saw; all of them where the log has only a few key scans."""
        return splines.seen_by_at_least(min(self.config.least_observations, len(self._steps)))

    def _current_observations(self) -> tuple[KeyObservations, ...]:
        """The decisions, with the ids that splines have after joins."""
        return tuple(
            replace(key, associations=tuple(map(self._builder.renamed, key.associations))) for key in self._observations
        )

    def _snapshot(self, splines: SplineMap, observations: tuple[KeyObservations, ...]) -> Snapshot:
        verdicts = {(closure.earlier, closure.scan): closure for closure in self._closer.closures}
        steps = tuple(
            replace(
                step,
                pose=pose,
                associations=key.associations,
                loop_closures=tuple(verdicts[one.earlier, one.scan] for one in step.loop_closures),
            )
            for step, pose, key in zip(self._steps, self._tracker.key_poses, observations, strict=False)
        )
        return Snapshot(
            poses=self._tracker.poses,
            key_scans=np.array([step.scan for step in steps], dtype=np.int64),
            steps=steps,
            map=splines,
            loop_closures=self._closer.told,
            estimate=self._estimate,
            observations=observations,
            pose_factors=self._pose_factors(),
            laser=self._laser,
        )


@in_one_thread
def run_slam(
    log: ScanLog, config: SlamConfig | None = None, *, progress: StageProgress = quiet, cancelled: Cancelling = never
) -> SlamResult:
    """The whole log, front end and adjustment. Raises Cancelled, LogError, SolverError."""
    config = config or SlamConfig()
    slam = Slam(log, config, cancelled)
    seconds: dict[str, float] = {}
    lost: list[int] = []
    unfit: list[int] = []
    started = perf_counter()
    for step in slam.steps():
        if step.lost:
            lost.append(step.scan)
        if step.unfit:
            unfit.append(step.scan)
        progress("scans", (step.scan + 1) / len(log), None)
    seconds["scans"] = perf_counter() - started
    started = perf_counter()
    snapshot = slam.finish(progress, cancelled)
    seconds["adjustment"] = perf_counter() - started
    return SlamResult(snapshot, seconds, tuple(lost), tuple(unfit))


def adjust(
    log: ScanLog,
    snapshot: Snapshot,
    config: SlamConfig,
    name: str,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
) -> Snapshot:
    """The snapshot adjusted again by the back end `name`: key poses and map move, all other scans follow. Raises
    Cancelled."""
    if len(snapshot.steps) == 0:
        raise SolverError(f"{log.name}: there is no key scan yet, so there is nothing to optimise")
    before = np.array([step.pose for step in snapshot.steps])
    splines, estimate = adjust_splines(
        snapshot.observations, before, snapshot.map, snapshot.pose_factors, config.adjustment, model_of(config), name,
        lambda fraction, record: progress("adjustment", fraction, record), cancelled,
    )  # fmt: skip
    steps = tuple(replace(step, pose=pose) for step, pose in zip(snapshot.steps, estimate.poses, strict=True))
    poses = carried_along(snapshot.poses, snapshot.key_scans, before, estimate.poses)
    return replace(snapshot, poses=poses, steps=steps, map=splines, estimate=estimate)


def marginals(
    snapshot: Snapshot,
    name: str = "direct",
    poses: Sequence[int] = (),
    splines: Sequence[int] = (),
    cancelled: Cancelling = never,
) -> Marginals:
    """Marginal covariances of key poses (by position among the key scans) and of splines (by id), world frame.

    Raises SolverError before the first adjustment, and Cancelled.
    """
    if snapshot.estimate is None:
        raise SolverError("covariances come with an adjustment: optimise first")
    known = {int(k) for k in snapshot.estimate.graph.spline_ids}
    wanted = [s for s in splines if s in known]
    return back_end(name).covariances(snapshot.estimate, poses=poses, splines=wanted, cancelled=cancelled)
