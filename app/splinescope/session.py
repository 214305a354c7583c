"""The state of the page, shared by all browsers that look: one thread owns it, commands and messages change it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamStep, Snapshot
from splinescope import commands as ask
from splinescope import messages as told
from splinescope.activity import Activity, Work, duration
from splinescope.map_view import dead_reckoned, moved, view_map
from splinescope.playback import Playback, play_axis
from splinescope.preferences import Preferences
from splinescope.scan_view import view_scan
from splinescope.solution import Solution, solution_of
from splinescope.view import MapView, ScanView, View


class Estimator(Protocol):
    """Who computes: the worker's process, seen from the session."""

    def process(self, path: Path) -> int: ...
    def solve(self, path: Path, snapshot: Snapshot, back_end: str) -> int: ...
    def covariances(self, back_end: str) -> int: ...
    def cancel(self) -> None: ...


@dataclass(frozen=True, slots=True)
class Notice:
    """A sentence that has to reach the person now; `bad` if something went wrong."""

    title: str
    text: str
    bad: bool = False


class Session:
    """Everything the page shows and how it changes.

    `opener` reads a log in the background and answers with LogOpened or LogRefused. `revision` grows with every
    change; `notices` and `fit_wanted` are for the viewer to take.
    """

    def __init__(
        self,
        estimator: Estimator,
        opener: Callable[[ask.OpenLog], None],
        preferences: Preferences,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._estimator = estimator
        self._opener = opener
        self._clock = clock
        self.preferences = preferences
        self.revision = 0
        self.notices: list[Notice] = []
        self.fit_wanted = False
        self.troubles: tuple[str, ...] = ()
        self.opening: ask.OpenLog | None = None
        self.log: ScanLog | None = None
        self._path: Path | None = None
        self._clear("")

    def _clear(self, title: str) -> None:
        self.title = title
        axis = play_axis(self.log.times) if self.log is not None else np.zeros(0)
        self.playback = Playback(axis, speed=self.preferences.speed)
        self.following = True
        self.selection = None
        self.steps: dict[int, SlamStep] = {}
        self.processed = 0
        self.snapshot: Snapshot | None = None
        self._settled: Snapshot | None = None
        self.covariances: dict[int, np.ndarray] = {}
        self.activity: Activity | None = None
        self.costs: tuple[float, ...] = ()
        self.solution: Solution | None = None
        self._solver, self._solve_start = self.preferences.back_end, 0.0
        self._map_view: MapView | None = None
        self._scan_view: tuple[tuple[object, ...], ScanView] | None = None

    # -- what is shown -----------------------------------------------------------------------------------------
    @property
    def cursor(self) -> int:
        return self.playback.cursor

    @property
    def busy(self) -> bool:
        """The estimator changes the map right now."""
        return self.activity is not None and self.activity.work in (Work.PROCESSING, Work.OPTIMISING)

    @property
    def view(self) -> View:
        """One frame of the page."""
        chosen = self.preferences
        return View(self.map_view, self.scan_view, chosen.layers, self.selection, chosen.dark)

    @property
    def map_view(self) -> MapView | None:
        """The map; the same object as long as nothing in it changed."""
        if self._map_view is None and self.log is not None:
            self._map_view = view_map(self.log, self.snapshot, self.covariances)
        return self._map_view

    @property
    def scan_view(self) -> ScanView | None:
        """The scan under the cursor; the same object as long as it looks the same."""
        if self.log is None or not len(self.log):
            return None
        index = self.cursor
        pose, step = self.pose(index), self.steps.get(index)
        key = (index, tuple(pose), step)
        if self._scan_view is None or self._scan_view[0] != key:
            self._scan_view = (key, self._shown_anew(index, pose, step))
        return self._scan_view[1]

    def _shown_anew(self, index: int, pose: Float[np.ndarray, "3"], step: SlamStep | None) -> ScanView:
        if self._scan_view is not None and self._scan_view[0][::2] == (index, step):
            return replace(self._scan_view[1], pose=pose)
        assert self.log is not None
        return view_scan(self.log[index], pose, step)

    def pose(self, index: int) -> Float[np.ndarray, "3"]:
        """Where scan `index` was taken, by the best that is known: the estimate, else odometry from its end."""
        if self.snapshot is not None and index < len(self.snapshot.poses):
            return self.snapshot.poses[index]
        if index in self.steps:
            return self.steps[index].pose
        last = self.processed - 1
        odometry = self.log.odometry if self.log is not None else None
        if last < 0 or last not in self.steps:
            return dead_reckoned(index, 0, np.zeros(3), odometry)
        return dead_reckoned(index, last, self.steps[last].pose, odometry)

    # -- time --------------------------------------------------------------------------------------------------
    def tick(self) -> None:
        """Let playback run up to now."""
        if self.playback.playing:
            self._play(self.playback.advanced(self._clock()))

    def _play(self, playback: Playback) -> None:
        if playback.cursor != self.cursor and self.selection is not None and self.selection.kind == "segment":
            self.selection = None
        if (playback.cursor, playback.playing) != (self.cursor, self.playback.playing):
            self.revision += 1
        self.playback = playback

    # -- what a person asks ------------------------------------------------------------------------------------
    def apply(self, command: ask.Command) -> None:
        """Do what a command says."""
        self.revision += 1
        now, playback = self._clock(), self.playback
        match command:
            case ask.OpenLog():
                self.opening = command
                self._opener(command)
            case ask.LogOpened(request=request, log=log):
                self._opened(request, log)
            case ask.LogRefused(request=request, sentence=sentence):
                self._refused(request, sentence)
            case ask.Seek(index=index):
                self._move(playback.seek(index if index >= 0 else playback.count + index, now))
            case ask.SeekTime(seconds=seconds):
                self._seek_time(seconds)
            case ask.Step(by=by):
                self._move(playback.step(by, now))
            case ask.Play():
                self._move(playback.play(now))
            case ask.Pause():
                self._move(playback.pause(now))
            case ask.TogglePlay():
                self._move(playback.toggled(now))
            case ask.SetSpeed(speed=speed):
                self._set_speed(playback.with_speed(speed, now))
            case ask.ChangeSpeed(by=by):
                self._set_speed(playback.faster(by, now))
            case ask.FollowProcessing(on=on):
                self.following = on
                self._follow()
            case ask.Select(selection=selection):
                self.selection = selection
            case ask.Optimise(back_end=back_end):
                self._optimise(back_end)
            case ask.Cancel():
                self._cancel()
            case _:
                self.preferences = preferred(self.preferences, command)

    def _move(self, playback: Playback) -> None:
        self.following = False
        self._play(playback)

    def _set_speed(self, playback: Playback) -> None:
        self._play(playback)
        self.preferences = replace(self.preferences, speed=playback.speed)

    def _seek_time(self, seconds: float) -> None:
        if self.log is not None and len(self.log):
            self._move(self.playback.seek(self.log.index_at(self.log.times[0] + seconds), self._clock()))

    def _follow(self) -> None:
        if self.following and self.processed:
            self._play(replace(self.playback.seek(self.processed - 1, self._clock()), playing=False))

    def _opened(self, request: ask.OpenLog, log: ScanLog) -> None:
        if request != self.opening:
            return
        self.opening = None
        self._estimator.cancel()
        self.log, self._path, self.troubles = log, request.path, ()
        self._clear(request.title or log.name)
        self.fit_wanted = True
        if len(log):
            job = self._estimator.process(request.path)
            self.activity = Activity(Work.PROCESSING, job, "Starting the estimator")
            self._solve_start = self._clock()

    def _refused(self, request: ask.OpenLog, sentence: str) -> None:
        if request == self.opening:
            self.opening = None
        self.complain("This log cannot be opened", sentence)

    def complain(self, title: str, sentence: str) -> None:
        """Say that something went wrong: at once, and readable for later."""
        self.revision += 1
        self.troubles = (*self.troubles, sentence)[-3:]
        self.notices.append(Notice(title, sentence, bad=True))

    def _optimise(self, back_end: str) -> None:
        self.preferences = replace(self.preferences, back_end=back_end)
        refusal = self.why_not_optimise
        if refusal is not None or self.snapshot is None or self._path is None:
            self.notices.append(Notice("Nothing was optimised", refusal or "No log is open."))
            return
        self._estimator.cancel()
        self._settled, self._solver, self._solve_start = self.snapshot, back_end, self._clock()
        self.costs, self.solution = (), None
        job = self._estimator.solve(self._path, self.snapshot, back_end)
        self.activity = Activity(Work.OPTIMISING, job, "Sending the map to the estimator")

    @property
    def why_not_optimise(self) -> str | None:
        """A sentence on what stands in the way of optimising now; None if nothing does."""
        if self.log is None:
            return "No log is open."
        if self.activity is not None and self.activity.work is Work.OPTIMISING:
            return "The map is being optimised already."
        if self.busy:
            return "The log is still being processed; wait for its end, or cancel it and optimise what is there."
        if self.snapshot is None or not len(self.snapshot.key_scans):
            return "There is no map yet."
        if not self.snapshot.steps:
            return "What the map was made from was lost with the estimator. Open the log again to optimise it."
        return None

    def _cancel(self) -> None:
        if self.opening is not None:
            self.opening = None
        elif self.activity is None:
            self.notices.append(Notice("Nothing to cancel", "The estimator is idle."))
        else:
            self._estimator.cancel()
            self.activity = replace(self.activity, stage="Stopping", fraction=None, seconds_left=None)

    # -- what the estimator tells ------------------------------------------------------------------------------
    def receive(self, message: told.Message) -> None:
        """Take in what the estimator sent; messages of jobs that nobody waits for any more are dropped."""
        activity = self.activity
        if activity is None or message.job != activity.job:
            return
        self.revision += 1
        match message:
            case told.Progress(stage=stage, fraction=fraction, seconds_left=left):
                stage = stage[:1].upper() + stage[1:]
                self.activity = replace(activity, stage=stage, fraction=fraction, seconds_left=left)
            case told.StepsDone(steps=steps):
                self._record(steps)
            case told.MapChanged(snapshot=snapshot):
                self._show(snapshot)
                self._settled = self.snapshot
            case told.Iterated(record=record):
                self._iterated(record)
            case told.CovariancesFound(splines=splines):
                self.covariances, self._map_view = splines, None
            case told.Finished(snapshot=snapshot):
                self._finished(activity, snapshot)
            case told.Stopped(snapshot=snapshot):
                self._stopped(activity, snapshot)
            case told.Failed(sentence=sentence):
                self._give_up(f"{activity.work.value} failed", sentence)

    def _record(self, steps: tuple[SlamStep, ...]) -> None:
        self.steps.update((step.scan, step) for step in steps)
        self.processed = max(self.processed, *(step.scan + 1 for step in steps))
        self._follow()

    def _show(self, snapshot: Snapshot | None) -> None:
        if snapshot is not self.snapshot:
            self.snapshot, self._map_view, self.covariances = snapshot, None, {}
            self.revision += 1

    def _iterated(self, record: IterationRecord) -> None:
        self.costs = (*self.costs, float(record.cost)) if record.index else (float(record.cost),)
        if self._settled is not None:
            self._show(moved(self._settled, record))

    def _finished(self, activity: Activity, snapshot: Snapshot | None) -> None:
        self.activity = None
        if snapshot is None:
            return
        before, seconds = self._settled, self._clock() - self._solve_start
        self._show(snapshot)
        self._settled = snapshot
        self.steps.update((step.scan, step) for step in snapshot.steps)
        self.processed = max(self.processed, len(snapshot.poses))
        self._follow()
        self.solution = solution_of(self._solver, before, snapshot, seconds)
        if snapshot.estimate is not None:
            self.costs = tuple(float(record.cost) for record in snapshot.estimate.iterations)
        self.notices.append(self._done(activity, snapshot, seconds))
        self.activity = Activity(Work.COVARIANCES, self._estimator.covariances(self._solver), "Waiting its turn")

    def _done(self, activity: Activity, snapshot: Snapshot, seconds: float) -> Notice:
        if activity.work is Work.OPTIMISING and self.solution is not None:
            found = self.solution
            return Notice(
                "The map is optimised",
                f"Cost {found.cost_before:,.1f} → {found.cost_after:,.1f}; "
                f"the largest move of a pose was {1000 * found.largest_move:.1f} mm.",
            )
        return Notice(
            "The log is processed",
            f"{len(snapshot.poses):,} scans gave {len(snapshot.map):,} splines in {duration(seconds)}.",
        )

    def _stopped(self, activity: Activity, snapshot: Snapshot | None) -> None:
        self.activity = None
        if snapshot is not None:
            self._show(snapshot)
            self._settled = snapshot
            text = f"{len(snapshot.poses):,} of {self.playback.count:,} scans are in the map; it can be optimised."
        else:
            self._show(self._settled)
            text = "The map stands as it was before."
        self.notices.append(Notice(f"{activity.work.value} was stopped", text))

    def _give_up(self, title: str, sentence: str) -> None:
        self.revision += 1
        self.activity = None
        self._show(self._settled)
        self.complain(title, sentence)


def preferred(preferences: Preferences, command: ask.Command) -> Preferences:
    """The preferences after a command that changes nothing else."""
    layers = preferences.layers
    match command:
        case ask.SetLayer(layer=layer, on=on):
            return replace(preferences, layers=layers | {layer} if on else layers - {layer})
        case ask.ToggleLayers(layers=group):
            return replace(preferences, layers=layers - group if group <= layers else layers | group)
        case ask.SetDark(dark=dark):
            return replace(preferences, dark=not preferences.dark if dark is None else dark)
        case ask.FollowRobot(on=on):
            return replace(preferences, follow_robot=on)
        case _:
            return preferences
