"""The pipeline: from a log to a map, one scan at a time; what it saw and decided is recorded as frozen steps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from jaxtyping import Float

from bspline_slam.adjustment.adjust import Foreseen, adjust_splines, foreseen
from bspline_slam.backends.protocol import Cancelling, Estimate, never
from bspline_slam.backends.threads import in_one_thread
from bspline_slam.calibration.laser import LaserCalibration, laser_calibration
from bspline_slam.calibration.laser_correction import LaserCorrection
from bspline_slam.calibration.odometry_noise import with_learnt_noise
from bspline_slam.calibration.velocities import velocities
from bspline_slam.errors import Cancelled
from bspline_slam.front_end.key_map import KeyMap
from bspline_slam.front_end.odometry_signs import odometry_signs
from bspline_slam.front_end.revisits import Revisits
from bspline_slam.front_end.tracking import Tracker
from bspline_slam.localisation import place_on_curves
from bspline_slam.models.protocol import Model
from bspline_slam.progress import StageProgress, quiet
from bspline_slam.scan import LaserScan, ScanLog
from bspline_slam.segmentation import segment_scan
from bspline_slam.sights import KeyObservations
from bspline_slam.slam_config import SlamConfig, check_names, model_of
from bspline_slam.snapshot import SlamStep, Snapshot
from bspline_slam.sound_log import check_log
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.tidy_map import tidied


@dataclass(frozen=True, eq=False, slots=True)
class SlamResult:
    """A finished run: the estimate, wall seconds by stage, and the scans (by index) that were lost on the way or whose
    odometry was `unfit`, not believed because it did not fit what scans show."""

    snapshot: Snapshot
    seconds: dict[str, float]
    lost: tuple[int, ...] = ()
    unfit: tuple[int, ...] = ()


@in_one_thread
def run_slam(
    log: ScanLog, config: SlamConfig | None = None, *, progress: StageProgress = quiet, cancelled: Cancelling = never
) -> SlamResult:
    """The whole log, front end and adjustment. Raises Cancelled, LogError, SolverError."""
    slam = Slam(log, config or SlamConfig(), cancelled)
    lost, unfit = [], []
    started = perf_counter()
    for step in slam.steps():
        if step.lost:
            lost.append(step.scan)
        if step.unfit:
            unfit.append(step.scan)
        progress("scans", (step.scan + 1) / len(log), None)
    read = perf_counter()
    snapshot = slam.finish(progress, cancelled)
    seconds = {"scans": read - started, "adjustment": perf_counter() - read}
    return SlamResult(snapshot, seconds, tuple(lost), tuple(unfit))


@dataclass
class Slam:
    """B-spline SLAM over a log. State: where scans lie, the map of the key scans, places seen again, and the step of
    each key scan."""

    log: ScanLog
    config: SlamConfig = field(default_factory=SlamConfig)
    cancelled: Cancelling = never
    _model: Model = field(init=False)
    _tracker: Tracker = field(init=False)
    _map: KeyMap = field(init=False)
    _revisits: Revisits = field(init=False)
    _steps: list[SlamStep] = field(default_factory=list)
    _estimate: Estimate | None = None
    _laser: LaserCalibration = LaserCalibration()

    def __post_init__(self) -> None:
        c = self.config
        check_names(c)
        self._model = model_of(c)
        self._tracker = self._new_tracker()
        self._map = KeyMap(c.association, self._model)
        self._revisits = Revisits(c, self._tracker.chain, self._map)

    def steps(self) -> Iterator[SlamStep]:
        """Process the log in its order, one step per scan. Raises LogError for a log that cannot be
        mapped, and Cancelled between scans."""
        check_log(self.log)
        odometry = self.log.odometry
        if odometry is not None:
            self._tracker.wheels.assume(odometry_signs(self.log, odometry, self._new_tracker))
        for scan in self.log:
            if self.cancelled():
                raise Cancelled(f"cancelled at scan {scan.index}")
            yield self.process(scan, None if odometry is None else odometry[scan.index])

    def process(self, scan: LaserScan, odometry: Float[np.ndarray, "3"] | None) -> SlamStep:
        """One scan: track it; if it is a key scan, close loops, cut it into segments, associate them, grow the
        map."""
        tracked = self._tracker.track(scan, odometry)
        step = SlamStep(
            scan.index, tracked.predicted, tracked.pose, tracked.key, tracked.lost, tracked.score, unfit=tracked.unfit
        )
        if not tracked.key:
            return step
        closures = self._revisits.look()
        segments, pose = segment_scan(scan, self.config.segmentation), self._tracker.chain.poses[-1]
        beams, sensor = int(np.count_nonzero(scan.valid)), scan.pose_robot_sensor[:2]
        seen = KeyObservations(scan.index, segments, (), beams, sensor)
        associations = self._map.add(seen, pose, lost=tracked.lost)
        step = replace(step, pose=pose, segments=segments, associations=associations, loop_closures=closures)
        self._steps.append(step)
        return step

    def snapshot(self) -> Snapshot:
        """The estimate as it stands."""
        return self._snapshot(self._map.splines, self._map.observations())

    def finish(self, progress: StageProgress = quiet, cancelled: Cancelling = never) -> Snapshot:
        """Solve the pose graph, build the map anew about where adjustment is going to put the key scans, make each
        wall one spline, adjust everything. Loop closures that turn out to be wrong on the way are taken back. Raises
        Cancelled."""
        progress("pose graph", 0.0, None)
        self._revisits.finish()
        correction = self._correct(cancelled)
        self._map.rebuild(self._key_poses)
        keys, tidy = self._tidied()
        splines, estimate = self._adjusted(keys, tidy, progress, cancelled)
        if self._revisits.closer.reject_contradicted(estimate.poses):
            splines, estimate = self._adjusted(keys, tidy, progress, cancelled)
        self._tracker.chain.move(estimate.poses)
        self._estimate = estimate
        snapshot, c = self._snapshot(splines, keys), self.config
        poses = place_on_curves(
            self.log, snapshot.poses, snapshot.key_scans, splines, c.localisation, c.matching, c.segmentation,
            correction.scan, lambda fraction: progress("scans between", fraction, None), cancelled,
        )  # fmt: skip
        return replace(snapshot, poses=poses)

    # -- steps of `finish` -------------------------------------------------------------------------------------
    def _correct(self, cancelled: Cancelling) -> LaserCorrection:
        """Put key scans about where the adjustment is going to put them; weigh odometry by how well it tells that, and
        correct their beams by what of their errors is the laser's."""
        c, chain = self.config, self._tracker.chain
        told = foreseen(
            self._map.observations(), self._key_poses, self._worthy(self._map.splines), self._revisits.pose_factors,
            c.adjustment, self._model, c.back_end, cancelled,
        )  # fmt: skip
        chain.move(told.estimate.poses)
        chain.factors = with_learnt_noise(chain.factors, told.estimate.poses, c.motion)
        correction = self._laser_correction(told)
        self._laser = correction.calibration
        self._map.correct(correction)
        return correction

    def _laser_correction(self, told: Foreseen) -> LaserCorrection:
        """What a rough estimate tells of the laser; nothing where the model measures along curves, too."""
        beams = len(self.log[0].ranges)
        if self._model.measures_along:
            return LaserCorrection(LaserCalibration(), np.zeros((0, 3)), beams)
        velocity = velocities(self.log.records, self._tracker.chain.scan_poses)
        keys = velocity[told.estimate.graph.key_scans]
        laser = laser_calibration(told, self.config.adjustment.outlier, self._model.fitting, beams, keys)
        return LaserCorrection(laser, velocity, beams)

    def _tidied(self) -> tuple[tuple[KeyObservations, ...], SplineMap]:
        """The decisions and the map to adjust, each wall one spline."""
        c, splines = self.config, self._worthy(self._map.splines)
        seen = self._map.observations()
        keys, splines = tidied(seen, self._key_poses, splines, c.merging, c.adjustment, self._model)
        return keys, self._worthy(splines)

    def _adjusted(
        self, keys: Sequence[KeyObservations], splines: SplineMap, progress: StageProgress, cancelled: Cancelling
    ) -> tuple[SplineMap, Estimate]:
        c = self.config
        return adjust_splines(
            keys, self._key_poses, splines, self._revisits.pose_factors, c.adjustment, self._model, c.back_end,
            lambda fraction, record: progress("adjustment", fraction, record), cancelled,
        )  # fmt: skip

    # -- what they share ---------------------------------------------------------------------------------------
    @property
    def _key_poses(self) -> Float[np.ndarray, "n 3"]:
        return np.array(self._tracker.chain.poses)

    def _new_tracker(self) -> Tracker:
        c = self.config
        return Tracker(c.tracking, c.matching, c.segmentation, c.motion)

    def _worthy(self, splines: SplineMap) -> SplineMap:
        """The splines that enough key scans saw; all of them where the log has only a few key scans."""
        return splines.seen_by_at_least(min(self.config.least_observations, len(self._steps)))

    def _snapshot(self, splines: SplineMap, observations: tuple[KeyObservations, ...]) -> Snapshot:
        closer = self._revisits.closer
        verdicts = {(closure.earlier, closure.scan): closure for closure in closer.closures}
        steps = tuple(
            replace(
                step,
                pose=pose,
                segments=key.segments,
                associations=key.associations,
                loop_closures=tuple(verdicts[one.earlier, one.scan] for one in step.loop_closures),
            )
            for step, pose, key in zip(self._steps, self._tracker.chain.poses, observations, strict=False)
        )
        return Snapshot(
            poses=self._tracker.chain.scan_poses,
            key_scans=np.array([step.scan for step in steps], dtype=np.int64),
            steps=steps,
            map=splines,
            loop_closures=closer.told,
            estimate=self._estimate,
            observations=observations,
            pose_factors=self._revisits.pose_factors,
            laser=self._laser,
        )
