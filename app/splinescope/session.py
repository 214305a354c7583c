"""The session of the page, shared by all browsers that look: one thread owns it, commands and messages change it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bspline_slam.edits.edit import Edit
from bspline_slam.measuring import Picked
from bspline_slam.scan import ScanLog
from splinescope import commands as ask
from splinescope.answering import Answering, Nobody
from splinescope.browser.link import Link
from splinescope.browser.log_view import LogView
from splinescope.browser.preferences import Preferences
from splinescope.choosing import linked, preferred
from splinescope.closures import ClosurePage
from splinescope.computing.edit_messages import Ghost
from splinescope.computing.messages import LogFile, Measured, Message
from splinescope.edit_desk import EditDesk
from splinescope.editing import Editing
from splinescope.estimation import Estimation, Estimator
from splinescope.findings import Findings
from splinescope.journals import Journals
from splinescope.marks import next_mark
from splinescope.notice import Notice
from splinescope.observation_view import ObservationView
from splinescope.playback import Playback, play_axis
from splinescope.recipe import Recipe
from splinescope.recognition import recognition
from splinescope.result import Result
from splinescope.ruler import Ruler, picked_from
from splinescope.shown import NO_LOG, Shown
from splinescope.view import Selection


class Session(Shown):
    """What is shown, and how it changes.

    `opener` reads a log in the background and answers with LogOpened or LogRefused; `opening` is what it reads. Without
    an `editor` hand edits are never answered.
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
        super().__init__(preferences, Editing(editor or Nobody(), journals or Journals.of_user(), self, self.tell))
        self._estimator = estimator
        self._editable = editor is not None
        self._opener = opener
        self._clock = clock
        self._edit_desk = EditDesk(self, self.apply)
        self._link: Link | None = None
        self._editing_shown = False
        self.opening: ask.OpenLog | None = None

    # -- messages ------------------------------------------------------------------------------------------------
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
        if self._editable and not self.busy:
            self.editing.attend(self.log, self.result)

    # -- commands ------------------------------------------------------------------------------------------------
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
            case ask.SeekMark(kind=kind, by=by):
                self._seek_mark(kind, by)
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
                self.replay.show(self.frames, number)
            case ask.StepIteration(by=by):
                self.replay.step(self.frames, by)
            case ask.ShowClosure(number=number):
                self._show_closure(number)
            case ask.LookThere():
                self.look_wanted = self.around
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
            case _ if not self._edit_desk.apply(command):
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

    def _seek_mark(self, kind: str, by: int) -> None:
        place = next_mark(self.findings, kind, self.cursor, by)
        if place is not None:
            self._move(self.playback.seek(place, self._clock()))
        else:
            self.tell(Notice("No such mark", f"There is none {'later' if by > 0 else 'earlier'} on the timeline."))

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
            self.look_wanted = self.around

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
        for notice in recognition(log, self.preferences):
            self.tell(notice)
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

    def _look_as_before(self, seen: LogView) -> None:
        self.selection, self.place, self.tab = seen.selection, seen.place, seen.tab
        self.following = seen.cursor is None
        if seen.cursor is not None:
            self.playback = self.playback.seek(seen.cursor, self._clock())
        link, self._link = self._link, None
        if link is not None:
            self._follow_link(link)

    def _follow_link(self, link: Link) -> None:
        self.preferences = linked(self.preferences, link)
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
