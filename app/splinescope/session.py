"""The state of the page, shared by all browsers that look: one thread owns it, commands and messages change it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bspline_slam.edits.edit import Edit
from bspline_slam.measuring import Picked
from bspline_slam.scan import ScanLog
from splinescope import commands as ask
from splinescope import edit_desk
from splinescope.activity import Activity
from splinescope.answering import Answering, Nobody
from splinescope.browser.link import Link
from splinescope.browser.log_view import LogView
from splinescope.browser.preferences import Preferences
from splinescope.browser.values import Bounds, Place
from splinescope.choosing import preferred
from splinescope.closures import ClosurePage
from splinescope.computing.edit_messages import Ghost
from splinescope.computing.messages import LogFile, Measured, Message
from splinescope.computing.solution import Solution
from splinescope.editing import Editing
from splinescope.estimation import Estimation, Estimator
from splinescope.findings import Findings
from splinescope.journals import Journals
from splinescope.map_view import view_map
from splinescope.notice import Notice
from splinescope.observation_view import ObservationStep, ObservationView, view_observation
from splinescope.playback import Playback, play_axis
from splinescope.recipe import Recipe
from splinescope.replay import Frames, Replay
from splinescope.result import Result, Results
from splinescope.ruler import Ruler, picked_from, places
from splinescope.subject import Subject, subject_of
from splinescope.view import GhostView, MapView, ScanView, Selection, View

NO_LOG = "No log is open."


class Session:
    """Everything the page shows and how it changes.

    `opener` reads a log in the background and answers with LogOpened or LogRefused. `findings` is what is known of
    the open log and `estimation` the work on it (None: no log is open). `revision` grows with every change; `notices`,
    `fit_wanted` and `look_wanted`, what a page is led to, are for the viewer to take; a fit goes to `place`, where the
    log was looked at before, and opens `tab`.
    """

    def __init__(
        self,
        estimator: Estimator,
        opener: Callable[[ask.OpenLog], None],
        preferences: Preferences,
        clock: Callable[[], float] = time.monotonic,
        editor: Answering | None = None,
        journals: Journals | None = None,
    ) -> None:
        self._estimator = estimator
        self._editor = editor
        self._opener = opener
        self._clock = clock
        self.preferences = preferences
        self.revision = 0
        self.notices: list[Notice] = []
        self.troubles: tuple[str, ...] = ()
        self.fit_wanted = False
        self.look_wanted: Bounds | None = None
        self.opening: ask.OpenLog | None = None
        self.title = ""
        self.findings = Findings()
        self.estimation: Estimation | None = None
        self.recipe = Recipe()
        self._compared: tuple[Result, MapView] | None = None
        self.playback = Playback(speed=preferences.speed)
        self.following = True
        self.selection: Selection | None = None
        self.place: Place | None = None
        self.tab = ""
        self._link: Link | None = None
        self.ruler: Ruler | None = None
        self._replay = Replay()
        self._editing_shown = False
        self.closure_page = ClosurePage()
        self.observing = False
        self.observation_step = ObservationStep.PARAMETERS
        self._observation: tuple[tuple[object, ...], ObservationView | str] | None = None
        self.editing = Editing(editor or Nobody(), journals or Journals.of_user(), self, self.tell)
        self._subject: tuple[tuple[object, ...], Subject] | None = None
        self._ghost: tuple[tuple[object, ...], GhostView | None] | None = None

    # -- what is shown -------------------------------------------------------------------------------------------
    @property
    def log(self) -> ScanLog | None:
        return self.findings.log

    @property
    def cursor(self) -> int:
        return self.playback.cursor

    @property
    def map_view(self) -> MapView | None:
        """The map; the same object as long as nothing in it changed."""
        return self.findings.map_view

    @property
    def scan_view(self) -> ScanView | None:
        """The scan under the cursor; the same object as long as it looks the same."""
        return self.findings.scan_view(self.cursor)

    @property
    def view(self) -> View:
        """One frame of the page."""
        chosen = self.preferences
        world, scan = self._replayed or (self.map_view, self.scan_view)
        measured = places(self.ruler, world) if self.ruler is not None and world is not None else None
        seen = (world, scan, chosen.layers, self.selection, chosen.dark, self.compared_view)
        return View(*seen, chosen.colouring, measured, self.ghost, edit_desk.asks(self.editing))

    @property
    def subject(self) -> Subject:
        """What is selected, as the subject of an edit; found once, for every button asks for it."""
        key = (self.selection, self.scan_view, self.map_view, self.editing.piece)
        if self._subject is None or any(a is not b for a, b in zip(self._subject[0], key, strict=True)):
            self._subject = (key, subject_of(*key))
        return self._subject[1]

    @property
    def ghost(self) -> GhostView | None:
        """What hand edits would change; the same object as long as it looks the same."""
        editing = self.editing
        key = (editing.proposal, editing.draft, editing.explanation, self.findings.snapshot)
        if self._ghost is None or any(a is not b for a, b in zip(self._ghost[0], key, strict=True)):
            self._ghost = (key, edit_desk.ghost_view(self))
        return self._ghost[1]

    @property
    def frames(self) -> Frames:
        """The iterations that are kept of the solve behind the result shown; none while another one is being made."""
        result = self.result
        return () if result is None or self.busy or self.findings.snapshot is not result.snapshot else result.frames

    @property
    def frame(self) -> int | None:
        """Which of them is shown; None for the result."""
        return self._replay.number(self.frames)

    @property
    def _replayed(self) -> tuple[MapView, ScanView | None] | None:
        """Map and scan at the iteration shown; None for the result."""
        result, scan = self.result, self.scan_view
        if result is None or self.log is None:
            return None
        played = self._replay.map(self.frames, self.log, result.snapshot)
        if played is None:
            return None
        snapshot, world = played
        if scan is not None and self.cursor < len(snapshot.poses):
            scan = replace(scan, pose=snapshot.poses[self.cursor])
        return world, scan

    @property
    def observation(self) -> ObservationView | str:
        """The selected segment of the current key scan taken apart, or why there is none."""
        recipe = self.estimation.recipe if self.estimation is not None else Recipe()
        key = (self.scan_view, self.map_view, self.selection, recipe)
        if self._observation is None or self._observation[0] != key:
            self._observation = (key, view_observation(*key[:3], recipe.config()))
        return self._observation[1]

    @property
    def lost_scans(self) -> list[int]:
        """Indices of the scans lost so far, increasing."""
        return sorted(step.scan for step in self.findings.steps.values() if step.lost)

    @property
    def activity(self) -> Activity | None:
        """The running job; edits that are being made come first."""
        return self.editing.activity or (self.estimation.activity if self.estimation is not None else None)

    @property
    def solution(self) -> Solution | None:
        """The figures behind the result shown."""
        return self.estimation.solution if self.estimation is not None else None

    @property
    def costs(self) -> tuple[float, ...]:
        """The cost after each iteration of the running or latest solve."""
        return self.estimation.costs if self.estimation is not None else ()

    @property
    def busy(self) -> bool:
        """The map is being changed right now."""
        return self.estimation is not None and self.estimation.busy

    @property
    def results(self) -> Results:
        """All that was made of the open log."""
        return self.estimation.results if self.estimation is not None else Results()

    @property
    def result(self) -> Result | None:
        """The result that is shown; while another one is being made, the one shown before."""
        return self.results.shown

    @property
    def compared(self) -> Result | None:
        """The result that is laid over what is shown: the chosen one, or the last one while a new one is made."""
        return self.results.shown if self.busy else self.results.compared

    @property
    def compared_view(self) -> MapView | None:
        """That result as the page draws it; the same object as long as it is the same result."""
        result = self.compared
        if result is None or self.log is None:
            return None
        if self._compared is None or self._compared[0] is not result:
            self._compared = (result, view_map(self.log, result.snapshot, {}))
        return self._compared[1]

    @property
    def refusal(self) -> str | None:
        """A sentence on what stands in the way of optimising now; None if nothing does."""
        return self.estimation.solve_refusal(self.recipe) if self.estimation is not None else NO_LOG

    @property
    def run_refusal(self) -> str | None:
        """A sentence on what stands in the way of running over the log now; None if nothing does."""
        return self.estimation.run_refusal(self.recipe) if self.estimation is not None else NO_LOG

    @property
    def remembered(self) -> Preferences:
        """What is to be kept for the next visit: the preferences, with how the open log is looked at."""
        if self.log is None or not len(self.log):
            return self.preferences
        cursor = None if self.following else self.cursor
        seen = LogView(cursor, self.place, self.selection, self.tab)
        return self.preferences.with_view(self.log.content_hash, seen)

    @property
    def link(self) -> Link:
        """This moment, but for the place that each page looks at."""
        chosen = self.preferences
        return Link(self.cursor if self.log is not None else None, chosen.layers, None, chosen.colouring)

    # -- what happens --------------------------------------------------------------------------------------------
    def tick(self) -> None:
        """Let playback run up to now, and show edits that take longer than a moment."""
        shown, self._editing_shown = self._editing_shown, self.editing.activity is not None
        if shown != self._editing_shown:
            self.revision += 1
        if self.playback.playing:
            self._play(self.playback.advanced(self._clock()))

    def receive(self, message: Message) -> None:
        """Take in what the estimator sent."""
        if isinstance(message, Measured):
            if self.ruler is not None and self.ruler.job == message.job:
                self.revision += 1
                self.ruler = replace(self.ruler, found=message.found)
        elif self.estimation is not None:
            self.revision += 1
            self.estimation.receive(message)
            self._follow()
            self._attend()

    def hear(self, message: Message) -> None:
        """Take in what the editor sent."""
        self.revision += 1
        self.editing.receive(message)

    def amend(self, result: Result) -> None:
        """A result with hand edits takes the place of the one without."""
        if self.estimation is not None:
            self.estimation.amend(result)

    def glimpse(self, ghost: Ghost) -> None:
        """Show what the map nearly becomes."""
        if self.estimation is not None:
            self.estimation.glimpse(ghost)

    def handed(self, number: int, edits: tuple[Edit, ...], amended: bytes) -> None:
        """The result of this number with these edits, packed for the estimator."""
        if self.estimation is not None:
            self.estimation.handed(number, edits, amended)

    def _attend(self) -> None:
        """Edits are about the result shown."""
        if self._editor is not None and not self.busy:
            self.editing.attend(self.log, self.result)

    def tell(self, notice: Notice) -> None:
        """Say something: at once, and what is bad readable for later."""
        self.revision += 1
        self.notices.append(notice)
        if notice.bad:
            self.troubles = (*self.troubles, notice.text)[-3:]

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
                if selection != self.selection:
                    self.editing.target = self.editing.piece = 0
                self.selection = selection
            case ask.LookFrom(place=place):
                self.place = place
            case ask.ShowTab(name=name):
                self.tab = name
            case ask.FollowLink(link=link):
                self._follow_link(link)
            case ask.Leave():
                if not self.editing.leave():
                    self.ruler, self.selection = None, None if self.ruler is None else self.selection
            case ask.Measure():
                self._measure()
            case ask.LayRuler(picked=picked):
                self._lay_ruler(picked)
            case ask.ShowIteration(number=number):
                self._replay.show(self.frames, number)
            case ask.StepIteration(by=by):
                self._replay.step(self.frames, by)
            case ask.ShowClosure(number=number):
                self._show_closure(number)
            case ask.LeafThrough(page=page):
                self.closure_page = page
            case ask.ShowObservation(on=on):
                self.observing = not self.observing if on is None else on
            case ask.StepObservation(by=by):
                self._step_observation(by)
            case ask.Choose(recipe=recipe):
                self.recipe = recipe
            case ask.RunAgain() | ask.Optimise() | ask.ShowResult() | ask.CompareWith() | ask.DeleteResult():
                self._estimate(command)
            case ask.Cancel():
                self._cancel()
            case _ if not edit_desk.apply(self, command):
                self.preferences = preferred(self.preferences, command)

    # -- time ----------------------------------------------------------------------------------------------------
    def _play(self, playback: Playback) -> None:
        if (
            playback.cursor != self.cursor
            and self.selection is not None
            and self.selection.kind in ("segment", "pieces")
        ):
            self.selection = None
        if (playback.cursor, playback.playing) != (self.cursor, self.playback.playing):
            self.revision += 1
        self.playback = playback

    def _move(self, playback: Playback) -> None:
        self.following = False
        self._play(playback)

    def _seek_time(self, seconds: float) -> None:
        if self.log is not None and len(self.log):
            self._move(self.playback.seek(self.log.index_at(self.log.times[0] + seconds), self._clock()))

    def _set_speed(self, playback: Playback) -> None:
        self._play(playback)
        self.preferences = replace(self.preferences, speed=playback.speed)

    def _follow(self) -> None:
        if self.following and self.findings.processed:
            self._play(replace(self.playback.seek(self.findings.processed - 1, self._clock()), playing=False))

    def _show_closure(self, number: int) -> None:
        """A row that was clicked may be of a list that is gone by now."""
        snapshot = self.findings.snapshot
        if snapshot is not None and 0 <= number < len(snapshot.loop_closures):
            self._move(self.playback.seek(snapshot.loop_closures[number].scan, self._clock()))
            self.selection = Selection("closure", number)
            self.look_wanted = edit_desk.surroundings(self)

    def _step_observation(self, by: int) -> None:
        if self.observing and isinstance(self.observation, ObservationView):
            self.observation_step = self.observation_step.moved(by)
        self.observing = True

    # -- measuring -----------------------------------------------------------------------------------------------
    def _measure(self) -> None:
        picked = picked_from(self.selection, self.scan_view, self.map_view)
        ruler = self.ruler or Ruler()
        if picked is not None and picked not in ruler.picked[-1:]:
            self._lay_ruler(picked)
        else:
            self.ruler = ruler if self.ruler is None else None

    def _lay_ruler(self, picked: Picked) -> None:
        ruler = (self.ruler or Ruler()).picking(picked)
        if ruler.first is not None and ruler.second is not None and self.estimation is not None:
            asked = self.estimation.measure(ruler.first, ruler.second)
            ruler = replace(ruler, found=asked) if isinstance(asked, str) else replace(ruler, job=asked)
        self.ruler = ruler

    # -- logs and work -------------------------------------------------------------------------------------------
    def _opened(self, request: ask.OpenLog, log: ScanLog) -> None:
        if request != self.opening:
            return
        self._estimator.cancel()
        self.editing.close()
        self._recognise(log)
        self.preferences = replace(self.remembered, log=str(log.path.absolute()), log_hash=log.content_hash)
        self.opening, self.troubles, self.ruler = None, (), None
        self.closure_page = ClosurePage()
        self.title = request.title or log.name
        self.findings = Findings(log)
        file = LogFile(request.path, log.content_hash)
        self.estimation = Estimation(self._estimator, self.findings, file, self.tell)
        self.playback = Playback(play_axis(log.times) if len(log) else np.zeros(0), speed=self.preferences.speed)
        self.fit_wanted = True
        self._look_as_before(self.preferences.views.get(log.content_hash, LogView()))
        if len(log):
            if self.recipe != Recipe():
                said = f"{self.recipe.back_end}, {self.recipe.model}, order {self.recipe.order}, {self.recipe.knots}"
                self.tell(Notice("Your choices stay", f"This log is run with {said}. Change that under Estimate."))
            self.estimation.process(self.recipe)

    def _recognise(self, log: ScanLog) -> None:
        """Say so where the log that the session refers to has moved or changed."""
        path, before = str(log.path.absolute()), self.preferences
        if before.log == path and before.log_hash not in ("", log.content_hash):
            sentence = f"{log.name} is not what it was: edits and views of before stay away."
            self.tell(Notice("The log has changed", sentence))
        if before.log not in ("", path) and before.log_hash == log.content_hash:
            self.tell(Notice("The log has moved", f"It was {before.log} before."))

    def _look_as_before(self, seen: LogView) -> None:
        self.selection, self.place, self.tab = seen.selection, seen.place, seen.tab
        self.following = seen.cursor is None
        if seen.cursor is not None:
            self.playback = self.playback.seek(seen.cursor, self._clock())
        link, self._link = self._link, None
        if link is not None:
            self._follow_link(link)

    def _follow_link(self, link: Link) -> None:
        chosen = self.preferences
        layers, colouring = link.layers, link.colouring
        self.preferences = replace(
            chosen,
            layers=chosen.layers if layers is None else layers,
            colouring=chosen.colouring if colouring is None else colouring,
        )
        if link.nonsense:
            self.tell(Notice("Not all of the link is understood", f"It says {', '.join(link.nonsense)}."))
        if self.log is None:
            self._link = replace(link, nonsense=())
        elif link.scan is not None:
            self._move(self.playback.seek(link.scan, self._clock()).pause(self._clock()))

    def _refused(self, request: ask.OpenLog, sentence: str) -> None:
        if request == self.opening:
            self.opening = None
        self.tell(Notice("This log cannot be opened", sentence, bad=True))

    def _estimate(self, command: ask.Command) -> None:
        if self.estimation is None:
            self.tell(Notice("Nothing was done", NO_LOG))
            return
        match command:
            case ask.RunAgain():
                self.estimation.process(self.recipe)
            case ask.Optimise():
                self.estimation.solve(self.recipe)
            case ask.ShowResult(number=number):
                self.estimation.show(number)
            case ask.CompareWith(number=number):
                self.estimation.compare(number)
            case ask.DeleteResult(number=number):
                self.estimation.delete(number)
        self._attend()

    def _cancel(self) -> None:
        if self.opening is not None:
            self.opening = None
        elif self.estimation is None:
            self.tell(Notice("Nothing to cancel", NO_LOG))
        elif self.editing.activity is not None:
            self.editing.stop()
        else:
            self.estimation.cancel()
