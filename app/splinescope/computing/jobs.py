"""What the estimator's process does for the page: process a log, solve a map, measure how good it is."""

from __future__ import annotations

import logging
import pickle
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass

from bspline_slam import estimates, slam
from bspline_slam.backends.protocol import Marginals
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.edits.amend import amended, solved_again
from bspline_slam.edits.edit import Edit
from bspline_slam.errors import Cancelled, LogError, SplineSlamError, as_sentence
from bspline_slam.lab.certainty import sigmas_along
from bspline_slam.lab.scan_consistency import scan_consistency
from bspline_slam.logs import open_log
from bspline_slam.measuring import Measurement, Picked, factorised, measure
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamConfig, Snapshot
from splinescope.computing.handover import unpacked
from splinescope.computing.iterations import frames_of
from splinescope.computing.live_map import LiveMap
from splinescope.computing.messages import (
    ConsistencyFound,
    CovariancesFound,
    FindCovariances,
    Finished,
    LogFile,
    Measured,
    MeasureMap,
    Message,
    ProcessLog,
    QualityFound,
    Request,
    SolveMap,
    StepsDone,
    Stopped,
    for_looking_at,
)
from splinescope.computing.packed_result import SENT_BEFORE, PackedResult
from splinescope.computing.reporter import Reporter, failures_told
from splinescope.computing.solution import Solution, solution_of
from splinescope.quality import quality_of

logger = logging.getLogger(__name__)

Cancelling = Callable[[], bool]

PREPARING = "Preparing the estimator (the very first run compiles for a minute)"
READING = "Matching scans"
CHANGED = "it has changed since it was opened; open it again to go on with what it holds now"
PARCEL = 50
"""Steps in one message."""


class Jobs:
    """Does one request after the other; remembers the log, the latest map and the factor of the one measured in, so as
    not to make them again."""

    def __init__(self, send: Callable[[Message], None]) -> None:
        self._send = send
        self._log: ScanLog | None = None
        self._latest: Done | None = None
        self._asked: Done | None = None
        self._factor: tuple[Snapshot, Factor] | None = None
        self._amended: tuple[Done, tuple[Edit, ...], Snapshot] | None = None

    def do(self, request: Request, cancelled: Cancelling) -> None:
        """Do a request; whatever goes wrong in it is sent as a sentence."""
        with failures_told(request.job, self._send, "estimator"):
            self._do(request, cancelled)

    def _do(self, request: Request, cancelled: Cancelling) -> None:
        reporter = Reporter(request.job, self._send)
        match request:
            case ProcessLog(log=log, config=config):
                self._asked = self._amended = None
                self._latest = process(self._open(log), config, reporter, cancelled)
            case SolveMap(log=log, result=result):
                before, edited = self._with_edits(result, cancelled), bool(result.edits)
                self._latest = optimise(self._open(log), before, result.config, edited, reporter, cancelled)
            case FindCovariances(log=log, result=result):
                snapshot = self._with_edits(result, cancelled)
                judge(self._open(log), snapshot, result.config, reporter, cancelled)
                reporter.send(Finished(request.job))
            case MeasureMap(result=result, first=first, second=second):
                snapshot = self._with_edits(result, cancelled)
                reporter.send(Measured(request.job, self._measured(snapshot, first, second)))

    def _with_edits(self, result: PackedResult, cancelled: Cancelling) -> Snapshot:
        """A result with its edits, as the editor made it, or made here; the latest one is remembered."""
        base, edits = self._unpacked(result.kept), result.edits
        if not edits:
            return base.snapshot
        if self._amended is None or self._amended[0] is not base or self._amended[1] != edits:
            if result.amended is not None:
                after = unpacked(base.snapshot, result.amended)
            else:
                after = amended(base.snapshot, edits, result.config, cancelled=cancelled).snapshot
            self._amended = (base, edits, after)
        return self._amended[2]

    def _measured(self, snapshot: Snapshot, first: Picked, second: Picked) -> Measurement | str:
        if snapshot.estimate is None:
            return "This map was never solved as a whole."
        if self._factor is None or self._factor[0] is not snapshot:
            self._factor = (snapshot, factorised(snapshot.estimate))
        try:
            return measure(snapshot.estimate, snapshot.map, self._factor[1], first, second)
        except SplineSlamError as error:
            return as_sentence(str(error))

    def _unpacked(self, kept: bytes) -> Done:
        """What a request is about: the latest map, that of the request before, or another one."""
        known = (done for done in (self._asked, self._latest) if done is not None)
        if kept != SENT_BEFORE or self._asked is None:
            self._asked = next((done for done in known if done.kept == kept), None) or Done(pickle.loads(kept), kept)
        return self._asked

    def _open(self, file: LogFile) -> ScanLog:
        """The log that the page has read; LogError where it is another one by now."""
        log = self._log
        if log is None or log.content_hash != file.content_hash:
            log = open_log(file.path)
        if log.content_hash != file.content_hash:
            raise LogError(file.path, CHANGED)
        self._log = log
        return log


@dataclass(frozen=True, eq=False, slots=True)
class Done:
    """What a job made, and the same pickled for the page to keep."""

    snapshot: Snapshot
    kept: bytes

    @classmethod
    def of(cls, snapshot: Snapshot) -> Done:
        return cls(snapshot, pickle.dumps(snapshot))


def process(log: ScanLog, config: SlamConfig, reporter: Reporter, cancelled: Cancelling) -> Done:
    """The whole pipeline over one log, streaming what it does. A cancelled run keeps the map it has."""
    reporter.stage(PREPARING)
    start = time.monotonic()
    pipeline = slam.Slam(log, config, cancelled=cancelled)
    try:
        with closing(LiveMap(config)) as live:
            for step in pipeline.steps():
                reporter.step(live.carried(step))
                reporter.progress(READING, (step.scan + 1) / len(log))
                reporter.map(lambda: live.shown(pipeline.snapshot()))
        reporter.flush()
        before = pipeline.snapshot()
        snapshot = pipeline.finish(reporter.progress, cancelled)
    except Cancelled:
        reporter.flush()
        done = Done.of(pipeline.snapshot())
        send_steps(done.snapshot, reporter)
        reporter.send(Stopped(reporter.job, for_looking_at(done.snapshot), done.kept))
    else:
        solution = solution_of(log, config.back_end, before, snapshot, time.monotonic() - start)
        send_steps(snapshot, reporter)
        done = finished(snapshot, solution, reporter)
    return done


def finished(snapshot: Snapshot, solution: Solution | None, reporter: Reporter) -> Done:
    """The last word of a job that made a map."""
    done = Done.of(snapshot)
    frames = frames_of(snapshot.estimate.iterations) if snapshot.estimate is not None else ()
    reporter.send(Finished(reporter.job, for_looking_at(snapshot), solution, done.kept, frames))
    return done


def send_steps(snapshot: Snapshot, reporter: Reporter) -> None:
    """The final word on every key scan, in parcels that the page unpacks between two frames."""
    for first in range(0, len(snapshot.steps), PARCEL):
        reporter.send(StepsDone(reporter.job, snapshot.steps[first : first + PARCEL]))


def optimise(
    log: ScanLog, before: Snapshot, config: SlamConfig, edited: bool, reporter: Reporter, cancelled: Cancelling
) -> Done:
    """The map solved anew by the back end of the configuration, streaming its iterations; an `edited` one as the
    problem that the edits left."""
    reporter.stage("Building the graph")
    start = time.monotonic()
    if edited:
        snapshot = solved_again(before, config.back_end, reporter.progress, cancelled)
    else:
        snapshot = estimates.adjust(log, before, config, config.back_end, reporter.progress, cancelled)
    solution = solution_of(log, config.back_end, before, snapshot, time.monotonic() - start)
    return finished(snapshot, solution, reporter)


def judge(log: ScanLog, snapshot: Snapshot, config: SlamConfig, reporter: Reporter, cancelled: Cancelling) -> None:
    """Residuals, covariances as soon as they are known, then the slower tests of consistency."""
    reporter.stage("Measuring residuals")
    reporter.send(QualityFound(reporter.job, quality_of(log, snapshot, config)))
    reporter.stage("Computing covariances")
    found = covariances(snapshot, config.back_end, cancelled)
    reporter.send(CovariancesFound(reporter.job, found.splines, sigmas_along(snapshot.map, found.splines)))
    tests = scan_consistency(
        snapshot, config, found.poses, log.truth,
        lambda share: reporter.progress("Testing consistency", share), cancelled,
    )  # fmt: skip
    reporter.send(ConsistencyFound(reporter.job, tests))


def covariances(snapshot: Snapshot, back_end: str, cancelled: Cancelling) -> Marginals:
    """Covariances of all key poses and splines of a solved map; none where the map was never solved as a whole."""
    if snapshot.estimate is None:
        return Marginals({}, {})
    poses, splines = tuple(range(len(snapshot.key_scans))), tuple(map(int, snapshot.estimate.graph.spline_ids))
    return estimates.marginals(snapshot, back_end, poses, splines, cancelled)
