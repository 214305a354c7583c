"""What the estimator's process does for the page: process a log, solve a map, find and test covariances."""

from __future__ import annotations

import logging
import pickle
import time
from collections.abc import Callable
from pathlib import Path

from bspline_slam import slam
from bspline_slam.backends.protocol import Marginals
from bspline_slam.errors import Cancelled, SplineSlamError
from bspline_slam.lab.scan_consistency import scan_consistency
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Snapshot
from splinescope.messages import (
    ConsistencyFound,
    CovariancesFound,
    Failed,
    FindCovariances,
    Finished,
    Message,
    ProcessLog,
    Request,
    SolveMap,
    StepsDone,
    Stopped,
    for_looking_at,
)
from splinescope.reporter import Reporter
from splinescope.solution import solution_of

logger = logging.getLogger(__name__)

Send = Callable[[Message], None]
Cancelling = Callable[[], bool]

PREPARING = "Preparing the estimator (the very first run compiles for a minute)"
READING = "Matching scans"
PARCEL = 50
"""Steps in one message."""


class Jobs:
    """Does one request after the other; remembers the log and the latest map between them."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._path: Path | None = None
        self._log: ScanLog | None = None
        self._snapshot: Snapshot | None = None

    def do(self, request: Request, cancelled: Cancelling) -> None:
        """Do a request; whatever goes wrong in it is sent as a sentence."""
        try:
            self._do(request, cancelled)
        except Cancelled:
            self._send(Stopped(request.job))
        except SplineSlamError as error:
            self._send(Failed(request.job, str(error)))
        except Exception as error:
            logger.exception("job %d failed", request.job)
            self._send(Failed(request.job, f"The estimator failed unexpectedly ({type(error).__name__}: {error})."))

    def _do(self, request: Request, cancelled: Cancelling) -> None:
        reporter = Reporter(request.job, self._send)
        match request:
            case ProcessLog(path=path):
                self._snapshot = None
                self._snapshot = process(self._open(path), reporter, self._send, cancelled)
            case SolveMap(path=path, kept=kept, back_end=back_end):
                before = self._snapshot or pickle.loads(kept)
                self._snapshot = optimise(self._open(path), before, back_end, reporter, self._send, cancelled)
            case FindCovariances(back_end=back_end):
                self._judge(self._snapshot, back_end, reporter, cancelled)
                self._send(Finished(request.job))

    def _judge(self, snapshot: Snapshot | None, back_end: str, reporter: Reporter, cancelled: Cancelling) -> None:
        """Covariances as soon as they are known, then the slower tests of consistency."""
        reporter.stage("Computing covariances")
        found = covariances(snapshot, back_end)
        self._send(CovariancesFound(reporter.job, found.splines))
        if snapshot is None or self._log is None:
            return
        tests = scan_consistency(
            snapshot, slam.SlamConfig(), found.poses, self._log.truth,
            lambda share: reporter.progress("Testing consistency", share), cancelled,
        )  # fmt: skip
        self._send(ConsistencyFound(reporter.job, tests))

    def _open(self, path: Path) -> ScanLog:
        if self._log is None or path != self._path:
            self._log, self._path = open_log(path), path
        return self._log


def process(log: ScanLog, reporter: Reporter, send: Send, cancelled: Cancelling) -> Snapshot:
    """The whole pipeline over one log, streaming what it does. A cancelled run keeps the map it has."""
    reporter.stage(PREPARING)
    start = time.monotonic()
    pipeline = slam.Slam(log, cancelled=cancelled)
    try:
        for step in pipeline.steps():
            reporter.step(step)
            reporter.progress(READING, (step.scan + 1) / len(log))
            reporter.map(pipeline.snapshot)
        reporter.flush()
        before = pipeline.snapshot()
        snapshot = pipeline.finish(reporter.progress, cancelled)
    except Cancelled:
        reporter.flush()
        snapshot = pipeline.snapshot()
        send_steps(snapshot, reporter.job, send)
        send(Stopped(reporter.job, for_looking_at(snapshot), pickle.dumps(snapshot)))
    else:
        solution = solution_of(slam.SlamConfig().back_end, before, snapshot, time.monotonic() - start)
        send_steps(snapshot, reporter.job, send)
        send(Finished(reporter.job, for_looking_at(snapshot), solution, pickle.dumps(snapshot)))
    return snapshot


def send_steps(snapshot: Snapshot, job: int, send: Send) -> None:
    """The final word on every key scan, in parcels that the page unpacks between two frames."""
    for first in range(0, len(snapshot.steps), PARCEL):
        send(StepsDone(job, snapshot.steps[first : first + PARCEL]))


def optimise(
    log: ScanLog, before: Snapshot, back_end: str, reporter: Reporter, send: Send, cancelled: Cancelling
) -> Snapshot:
    """The map solved anew by one back end, streaming its iterations."""
    reporter.stage("Building the graph")
    start = time.monotonic()
    snapshot = slam.adjust(log, before, slam.SlamConfig(), back_end, reporter.progress, cancelled)
    solution = solution_of(back_end, before, snapshot, time.monotonic() - start)
    send(Finished(reporter.job, for_looking_at(snapshot), solution, pickle.dumps(snapshot)))
    return snapshot


def covariances(snapshot: Snapshot | None, back_end: str) -> Marginals:
    """Covariances of all key poses and splines of a solved map; none where the map was never solved as a whole."""
    if snapshot is None or snapshot.estimate is None:
        return Marginals({}, {})
    poses = tuple(range(len(snapshot.key_scans)))
    return slam.marginals(snapshot, back_end, poses, tuple(int(i) for i in snapshot.estimate.graph.spline_ids))
