"""The estimator's work on one log: asked for, listened to, taken into the findings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.slam import Snapshot
from splinescope import messages as told
from splinescope.activity import Activity, Work, duration
from splinescope.findings import Findings
from splinescope.map_view import moved
from splinescope.notice import Notice
from splinescope.solution import Solution


class Estimator(Protocol):
    """Who computes: the worker's process, seen from here."""

    def process(self, path: Path) -> int: ...
    def solve(self, path: Path, kept: bytes, back_end: str) -> int: ...
    def covariances(self, back_end: str) -> int: ...
    def cancel(self) -> None: ...


class Estimation:
    """One job at a time; what it brings goes into `findings`, what a person has to know to `tell`.

    `costs` are those of the running or latest solve, `solution` its figures. A solve that fails or is stopped leaves
    the map that stood before.
    """

    def __init__(
        self,
        estimator: Estimator,
        findings: Findings,
        path: Path,
        tell: Callable[[Notice], None],
    ) -> None:
        self._estimator = estimator
        self._findings = findings
        self._path = path
        self._tell = tell
        self._settled: Snapshot | None = None
        self._kept: bytes | None = None
        self._solver = "direct"
        self.activity: Activity | None = None
        self.costs: tuple[float, ...] = ()
        self.solution: Solution | None = None

    # -- asking --------------------------------------------------------------------------------------------------
    def process(self) -> None:
        """Let the whole log be processed."""
        self.activity = Activity(Work.PROCESSING, self._estimator.process(self._path), "Starting the estimator")

    def solve(self, back_end: str) -> None:
        """Let the map be solved by a back end, or say why not."""
        refusal, snapshot, kept = self.refusal, self._findings.snapshot, self._kept
        if refusal is not None or snapshot is None or kept is None:
            self._tell(Notice("Nothing was optimised", refusal or "There is no map yet."))
            return
        self._estimator.cancel()
        self._settled, self._solver = snapshot, back_end
        self.costs, self.solution = (), None
        job = self._estimator.solve(self._path, kept, back_end)
        self.activity = Activity(Work.OPTIMISING, job, "Sending the map to the estimator")

    def cancel(self) -> None:
        """Let the running job be stopped."""
        if self.activity is None:
            self._tell(Notice("Nothing to cancel", "The estimator is idle."))
            return
        self._estimator.cancel()
        self.activity = replace(self.activity, stage="Stopping", fraction=None, seconds_left=None)

    @property
    def busy(self) -> bool:
        """The map is being changed right now."""
        return self.activity is not None and self.activity.work in (Work.PROCESSING, Work.OPTIMISING)

    @property
    def refusal(self) -> str | None:
        """A sentence on what stands in the way of optimising now; None if nothing does."""
        snapshot = self._findings.snapshot
        if self.activity is not None and self.activity.work is Work.OPTIMISING:
            return "The map is being optimised already."
        if self.busy:
            return "The log is still being processed; wait for its end, or cancel it and optimise what is there."
        if snapshot is None or not len(snapshot.key_scans):
            return "There is no map yet."
        if self._kept is None:
            return "What the map was made from was lost with the estimator. Open the log again to optimise it."
        return None

    # -- listening -----------------------------------------------------------------------------------------------
    def receive(self, message: told.Message) -> None:
        """Take in what the estimator sent; messages of jobs that nobody waits for any more are dropped."""
        activity = self.activity
        if activity is None or message.job != activity.job:
            return
        match message:
            case told.Progress(stage=stage, fraction=fraction, seconds_left=left):
                said = stage[:1].upper() + stage[1:]
                self.activity = replace(activity, stage=said, fraction=fraction, seconds_left=left)
            case told.StepsDone(steps=steps):
                self._findings.record(steps)
            case told.MapChanged(snapshot=snapshot):
                self._settle(snapshot)
            case told.Iterated(record=record):
                self._iterated(record)
            case told.CovariancesFound(splines=splines):
                self._findings.know(splines)
            case told.ConsistencyFound(tests=tests):
                self._findings.consistency = tests
            case told.Finished():
                self._finished(activity, message)
            case told.Stopped():
                self._stopped(activity, message)
            case told.Failed(sentence=sentence):
                self.activity = None
                self._findings.show(self._settled)
                self._tell(Notice(f"{activity.work.value} failed", sentence, bad=True))

    def _settle(self, snapshot: Snapshot) -> None:
        self._findings.show(snapshot)
        self._settled = snapshot

    def _iterated(self, record: IterationRecord) -> None:
        self.costs = (*self.costs, float(record.cost)) if record.index else (float(record.cost),)
        if self._settled is not None:
            self._findings.show(moved(self._settled, record))

    def _finished(self, activity: Activity, end: told.Finished) -> None:
        self.activity = None
        if end.snapshot is None:
            return
        self._settle(end.snapshot)
        self._kept, self.solution = end.kept, end.solution
        if end.solution is not None:
            self.costs = end.solution.costs
        self._tell(done(activity, end.snapshot, end.solution))
        self.activity = Activity(Work.COVARIANCES, self._estimator.covariances(self._solver), "Waiting its turn")

    def _stopped(self, activity: Activity, end: told.Stopped) -> None:
        self.activity, snapshot = None, end.snapshot
        if snapshot is not None:
            self._settle(snapshot)
            self._kept = end.kept
            scans = len(self._findings.log) if self._findings.log is not None else 0
            text = f"{len(snapshot.poses):,} of {scans:,} scans are in the map; it can be optimised."
        else:
            self._findings.show(self._settled)
            text = "The map stands as it was before."
        self._tell(Notice(f"{activity.work.value} was stopped", text))


def done(activity: Activity, snapshot: Snapshot, solution: Solution | None) -> Notice:
    """What to say at the end of a job."""
    if activity.work is Work.OPTIMISING and solution is not None:
        return Notice(
            "The map is optimised",
            f"Cost {solution.cost_before:,.1f} → {solution.cost_after:,.1f}; "
            f"the largest move of a pose was {1000 * solution.largest_move:.1f} mm.",
        )
    time_taken = f" in {duration(solution.seconds)}" if solution is not None else ""
    return Notice(
        "The log is processed", f"{len(snapshot.poses):,} scans gave {len(snapshot.map):,} splines{time_taken}."
    )
