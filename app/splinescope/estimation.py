"""The estimator's work on one log: asked for, listened to, taken into the findings; its latest results are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.edits.edit import Edit
from bspline_slam.measuring import Picked
from bspline_slam.slam import Snapshot
from splinescope.activity import Activity, Work, stage_in_words
from splinescope.computing import messages as told
from splinescope.computing.edit_messages import Ghost
from splinescope.computing.solution import Solution
from splinescope.estimation_text import AT_WORK, UNCHANGED, done, unfit, unsolvable
from splinescope.estimator import Estimator
from splinescope.findings import Findings
from splinescope.map_view import moved
from splinescope.notice import Notice
from splinescope.recipe import Recipe
from splinescope.result import KEPT, Result, Results


class Estimation:
    """One job at a time; what it brings goes into `findings`, what a person has to know to `tell`.

    Each job that ends with a map adds to `results`. One that fails or is stopped leaves the result shown before; the
    map of a run over the log that was stopped is kept beside it, and shown where it is the first. `costs` are those
    of the running solve or of the one behind the result shown.
    """

    def __init__(
        self, estimator: Estimator, findings: Findings, log: told.LogFile, tell: Callable[[Notice], None]
    ) -> None:
        self._estimator = estimator
        self._findings = findings
        self._file = log
        self._tell = tell
        self._settled: Snapshot | None = None
        self._recipe = Recipe()
        self._run: Result | None = None
        self._measuring: int | None = None
        self._given_up: set[int] = set()
        self.results = Results()
        self.activity: Activity | None = None
        self.costs: tuple[float, ...] = ()

    # -- asking --------------------------------------------------------------------------------------------------
    def process(self, recipe: Recipe) -> None:
        """Let the whole log be processed, or say why not."""
        if self._refused("Nothing was run", self.run_refusal(recipe)):
            return
        self._begin(recipe, None)
        self._findings.forget()
        job = self._estimator.process(self._file, recipe.config())
        self.activity = Activity(Work.PROCESSING, job, "Starting the estimator")

    def solve(self, recipe: Recipe) -> None:
        """Let the run behind the map shown, with its hand edits, be solved by the recipe's back end, or say why not."""
        shown = self.results.shown
        if self._refused("Nothing was optimised", self.solve_refusal(recipe)) or shown is None:
            return
        run = self._run = self.results.run_behind(shown)
        self._begin(recipe, run.snapshot)
        job = self._estimator.solve(self._file, replace(run.packed, config=recipe.config()))
        self.activity = Activity(Work.OPTIMISING, job, "Sending the map to the estimator")

    def cancel(self) -> None:
        """Let the running job be stopped."""
        if self.activity is None:
            self._tell(Notice("Nothing to cancel", "The estimator is idle."))
            return
        self._estimator.cancel()
        self.activity = replace(self.activity, stage="Stopping", fraction=None, seconds_left=None)

    def _begin(self, recipe: Recipe, settled: Snapshot | None) -> None:
        self._estimator.cancel()
        self._recipe, self._settled, self.costs = recipe, settled, ()

    def _refused(self, title: str, refusal: str | None) -> bool:
        if refusal is not None:
            self._tell(Notice(title, refusal))
        return refusal is not None

    @property
    def busy(self) -> bool:
        """The map is being changed right now."""
        return self.activity is not None and self.activity.work in (Work.PROCESSING, Work.OPTIMISING)

    @property
    def recipe(self) -> Recipe:
        """What the map that can be seen is made by."""
        shown = self.results.shown
        return self._recipe if self.busy or shown is None else shown.recipe

    @property
    def solution(self) -> Solution | None:
        """The figures behind the result shown; None while another one is being made."""
        shown = self.results.shown
        return None if self.busy or shown is None else shown.solution

    def measure(self, first: Picked, second: Picked) -> int | str:
        """Let two things of the map shown be measured: the number of the job, or a sentence on why not."""
        shown = self.results.shown
        if self.busy:
            return "The map is being changed; measure when that has ended."
        if shown is None or shown.solution is None or self._findings.snapshot is not shown.snapshot:
            return "There is no solved map to measure in."
        return self._estimator.measure(shown.packed, first, second)

    def run_refusal(self, recipe: Recipe) -> str | None:
        """A sentence on what stands in the way of running over the log now; None if nothing does."""
        return AT_WORK if self.busy else unfit(recipe)

    def solve_refusal(self, recipe: Recipe) -> str | None:
        """A sentence on what stands in the way of solving the map shown now; None if nothing does."""
        if self.activity is not None and self.activity.work is Work.OPTIMISING:
            return "The map is being optimised already."
        if self.busy:
            return "The log is still being processed; wait for its end, or cancel it and optimise what is there."
        if self.results.shown is None and self._findings.snapshot is not None:
            return "What the map was made from was lost with the estimator. Run the whole log again to optimise it."
        return unsolvable(self.results, recipe)

    # -- results -------------------------------------------------------------------------------------------------
    def show(self, number: int) -> None:
        """Show another result, or say why not."""
        result = self.results.find(number)
        if self._refused("Nothing was changed", self._choice_refusal(result)) or result is None:
            return
        self._given_up.discard(number)
        self.results = self.results.showing(result)
        self._take(result)
        self._measure()

    def compare(self, number: int | None) -> None:
        """Lay another result over the one shown; None for none."""
        self.results = self.results.comparing(self.results.find(number))
        self._measure()

    def delete(self, number: int) -> None:
        """Forget a result that is not shown, or say why not."""
        result = self.results.find(number)
        refusal = self._choice_refusal(result)
        if result is not None and result is self.results.shown:
            refusal = "The result that is shown stays; show another one before you delete it."
        if self._refused("Nothing was deleted", refusal) or result is None:
            return
        self.results = self.results.without(result)

    def amend(self, result: Result) -> None:
        """This is the result of its number from now on; what was measured of it before is void."""
        if self.results.find(result.number) is None:
            return
        self.results = self.results.updated(result)
        if self.busy:
            return
        if self.results.shown is result:
            self._take(result)
        self._leave_measuring(result)
        self._measure()

    def glimpse(self, ghost: Ghost) -> None:
        """Show what the result shown nearly becomes; what is being measured of it would be void."""
        shown = self.results.shown
        if shown is not None and not self.busy:
            self._leave_measuring(shown)
            self._findings.show(ghost.over(shown.snapshot))
            self._findings.decide(ghost.decided)

    def _leave_measuring(self, result: Result) -> None:
        if self.activity is not None and self._measuring == result.number:
            self._estimator.cancel()
            self.activity = None

    def handed(self, number: int, edits: tuple[Edit, ...], amended: bytes) -> None:
        """The result of this number with these edits, packed for the estimator, which measures it now."""
        result = self.results.find(number)
        if result is not None and result.edits == edits:
            self.results = self.results.updated(replace(result, amended=amended))
            self._measure()

    def _choice_refusal(self, result: Result | None) -> str | None:
        if self.busy:
            return AT_WORK
        return "There is no such result." if result is None else None

    def _take(self, result: Result) -> None:
        self._settled = result.snapshot
        self._findings.take(result)
        self.costs = result.solution.costs if result.solution is not None else ()

    def _restore(self) -> None:
        """Show again what was shown before a job that came to nothing."""
        if self.results.shown is not None:
            self._take(self.results.shown)
        else:
            self._findings.show(self._settled)

    def _measure(self) -> None:
        """Let missing figures of what is looked at be computed while the estimator has nothing else to do."""
        if self.activity is not None:
            return
        for result in (self.results.shown, self.results.compared):
            if result is None or (result.edits and result.amended is None):
                continue
            if not result.measured and result.number not in self._given_up:
                job = self._estimator.covariances(self._file, result.packed)
                self.activity = Activity(Work.COVARIANCES, job, Work.COVARIANCES.value)
                self._measuring = result.number
                return

    # -- listening -----------------------------------------------------------------------------------------------
    def receive(self, message: told.Message) -> None:
        """Take in what the estimator sent; messages of jobs that nobody waits for any more are dropped."""
        activity = self.activity
        if activity is None or message.job != activity.job:
            return
        match message:
            case told.Progress(stage=stage, fraction=fraction, seconds_left=left):
                self.activity = replace(activity, stage=stage_in_words(stage), fraction=fraction, seconds_left=left)
            case told.StepsDone(steps=steps):
                self._findings.record(steps)
            case told.MapChanged(snapshot=snapshot, adjusted=adjusted):
                self.activity = replace(activity, adjusted=adjusted)
                self._settle(snapshot)
            case told.Iterated(record=record):
                self._iterated(record)
            case told.QualityFound(quality=quality):
                self._learn(quality=quality)
            case told.CovariancesFound(splines=splines, sigmas=sigmas):
                self._learn(covariances=splines, sigmas=sigmas)
            case told.ConsistencyFound(tests=tests):
                self._learn(consistency=tests)
            case told.Finished():
                self._finished(activity, message)
            case told.Stopped():
                self._stopped(activity, message)
            case told.Failed(sentence=sentence):
                self._failed(activity, sentence)

    def _settle(self, snapshot: Snapshot) -> None:
        self._findings.show(snapshot)
        self._settled = snapshot

    def _iterated(self, record: IterationRecord) -> None:
        self.costs = (*self.costs, float(record.cost)) if record.index else (float(record.cost),)
        if self._settled is not None:
            self._findings.show(moved(self._settled, record))

    def _learn(self, **known: Any) -> None:
        """Note what has become known of the result that is being measured, and show it where that one is shown."""
        result = self.results.find(self._measuring)
        if result is None:
            return
        was_shown, result = result is self.results.shown, replace(result, **known)
        self.results = self.results.updated(result)
        if was_shown and self._findings.snapshot is result.snapshot:
            self._findings.know(result)

    def _finished(self, activity: Activity, end: told.Finished) -> None:
        self.activity = None
        if end.snapshot is not None and end.kept is not None:
            origin = self._run if activity.work is Work.OPTIMISING else None
            result = self._result(end.snapshot, end.kept, end.solution)
            origin = replace(origin, amended=None) if origin is not None else None
            self._show_new(replace(result, origin=origin, frames=end.frames))
            self._tell(done(activity, end.snapshot, end.solution, len(origin.edits) if origin is not None else 0))
        if activity.work is Work.COVARIANCES:
            self._learn(measured=True)
        self._measure()

    def _stopped(self, activity: Activity, end: told.Stopped) -> None:
        self.activity = None
        match activity.work:
            case Work.COVARIANCES:
                text = self._given_up_on()
            case Work.PROCESSING:
                text = self._part_done(end)
            case _:
                self._restore()
                text = UNCHANGED
        self._tell(Notice(f"{activity.work.value} was stopped", text))
        self._measure()

    def _part_done(self, end: told.Stopped) -> str:
        """Keep what a run did before it was stopped; says what became of it."""
        if end.snapshot is None or end.kept is None or not len(end.snapshot.key_scans):
            self._restore()
            return UNCHANGED
        scans = len(end.snapshot.poses)
        result = replace(self._result(end.snapshot, end.kept, None), stopped_after=scans)
        if self.results.shown is None:
            self._show_new(result)
            of_all = len(self._findings.log) if self._findings.log is not None else 0
            return f"{scans:,} of {of_all:,} scans are in the map; it can be optimised."
        self._add(result, show=False)
        self._restore()
        return f"{UNCHANGED} The {scans:,} scans done are kept as result {result.number}."

    def _given_up_on(self) -> str:
        """Leave the covariances of what is looked at unknown until somebody asks again."""
        looked_at = (self.results.shown, self.results.compared)
        self._given_up |= {result.number for result in looked_at if result is not None}
        return "The map stands. To have them computed after all, show the result again under Compare."

    def _failed(self, activity: Activity, sentence: str) -> None:
        self.activity = None
        if activity.work is Work.COVARIANCES:
            self._given_up_on()
        else:
            self._restore()
        self._tell(Notice(f"{activity.work.value} failed", sentence, bad=True))
        self._measure()

    def _result(self, snapshot: Snapshot, kept: bytes, solution: Solution | None) -> Result:
        findings = self._findings
        number, steps = self.results.made + 1, dict(findings.steps)
        return Result(number, self._recipe, snapshot, steps, findings.processed, kept, solution)

    def _show_new(self, result: Result) -> None:
        self._add(result)
        self._take(result)

    def _add(self, result: Result, show: bool = True) -> None:
        before, self.results = self.results, self.results.added(result, show)
        for gone in before.all:
            if self.results.find(gone.number) is None:
                self._tell(Notice(f"Result {gone.number} has left the list", f"The latest {KEPT} results are kept."))
