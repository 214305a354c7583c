"""The session of the page, shared by all browsers that look: one thread owns it, commands and messages change it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bspline_slam.edits.edit import Edit
from bspline_slam.scan import ScanLog
from splinescope import commands as ask
from splinescope.browser.log_view import LogView
from splinescope.browser.preferences import Preferences
from splinescope.choosing import preferred
from splinescope.closures import ClosurePage
from splinescope.computing.edit_messages import Ghost
from splinescope.computing.messages import LogFile, Measured, Message
from splinescope.edits.answering import Answering, Nobody
from splinescope.edits.edit_desk import EditDesk
from splinescope.edits.editing import Editing
from splinescope.edits.journals import Journals
from splinescope.estimation import Estimation
from splinescope.estimator import Estimator
from splinescope.findings import Findings
from splinescope.marks import next_mark
from splinescope.notice import Notice
from splinescope.playback import Playback, play_axis
from splinescope.playing import played
from splinescope.recipe import Recipe
from splinescope.recognition import recognition
from splinescope.result import Result
from splinescope.shown import NO_LOG, Shown
from splinescope.viewfinder import Viewfinder


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
        self._viewfinder = Viewfinder(self, self.apply)
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
        if isinstance(command, ask.PlaybackCommand):
            self._play_on(command)
        elif isinstance(command, ask.LookingCommand):
            self._viewfinder.apply(command)
        elif isinstance(command, ask.EditCommand):
            self._edit_desk.apply(command)
        elif isinstance(command, ask.PreferenceCommand):
            self.preferences = preferred(self.preferences, command)
        elif isinstance(command, ask.LogCommand):
            self._read(command)
        else:
            self._work(command)

    def _play_on(self, command: ask.PlaybackCommand) -> None:
        match command:
            case ask.FollowProcessing(on=on):
                self.following = on
                self._follow()
            case ask.SeekTime(seconds=seconds):
                if self.log is not None and len(self.log):
                    self._seek(self.log.index_at(self.log.times[0] + seconds))
            case ask.SeekMark(kind=kind, by=by):
                self._seek_mark(kind, by)
            case ask.SetSpeed() | ask.ChangeSpeed():
                self._play(played(self.playback, command, self._clock()))
                self.preferences = replace(self.preferences, speed=self.playback.speed)
            case _:
                self._move(played(self.playback, command, self._clock()))

    def _read(self, command: ask.LogCommand) -> None:
        match command:
            case ask.OpenLog():
                self.opening = command
                self._opener(command)
            case ask.LogOpened(request=request, log=log):
                self._opened(request, log)
            case ask.LogRefused(request=request, sentence=sentence):
                self._refused(request, sentence)

    def _work(self, command: ask.WorkCommand) -> None:
        match command:
            case ask.Choose(recipe=recipe):
                self.recipe = recipe
            case ask.Cancel():
                self._cancel()
            case _ if self.estimation is None:
                self.tell(Notice("Nothing was done", NO_LOG))
            case _:
                self._estimate(self.estimation, command)
                self._attend()

    def _estimate(self, estimation: Estimation, command: ask.WorkCommand) -> None:
        match command:
            case ask.RunAgain():
                estimation.process(self.recipe)
            case ask.Optimise():
                estimation.solve(self.recipe)
            case ask.ShowResult(number=number):
                estimation.show(number)
            case ask.CompareWith(number=number):
                estimation.compare(number)
            case ask.DeleteResult(number=number):
                estimation.delete(number)

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

    def _seek(self, index: int) -> None:
        self._move(self.playback.seek(index, self._clock()))

    def _seek_mark(self, kind: str, by: int) -> None:
        place = next_mark(self.findings, kind, self.cursor, by)
        if place is not None:
            self._seek(place)
        else:
            self.tell(Notice("No such mark", f"There is none {'later' if by > 0 else 'earlier'} on the timeline."))

    def _follow(self) -> None:
        if self.following and self.findings.processed:
            self._play(replace(self.playback.seek(self.findings.processed - 1, self._clock()), playing=False))

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
        self._viewfinder.look_as_before(self.preferences.views.get(log.content_hash, LogView()))
        if len(log):
            if self.recipe != Recipe():
                said = f"{self.recipe.back_end}, {self.recipe.model}, order {self.recipe.order}, {self.recipe.knots}"
                self.tell(Notice("Your choices stay", f"This log is run with {said}. Change that under Estimate."))
            self.estimation.process(self.recipe)

    def _refused(self, request: ask.OpenLog, sentence: str) -> None:
        if request == self.opening:
            self.opening = None
        self.tell(Notice("This log cannot be opened", sentence, bad=True))

    def _cancel(self) -> None:
        if self.opening is not None:
            self.opening = None
        elif self.estimation is None:
            self.tell(Notice("Nothing to cancel", NO_LOG))
        elif self.editing.activity is not None:
            self.editing.stop()
        else:
            self.estimation.cancel()
