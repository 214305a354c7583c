"""Hand edits on a finished run: proposed, looked at, accepted, kept in the journal, taken back and made again."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from bspline_slam.edits.doubts import Doubt
from bspline_slam.edits.edit import FIRST_MADE_BY_HAND, Edit, splines_made
from bspline_slam.edits.explain import Explanation
from bspline_slam.edits.history import Accept, Accepted, GoTo, History, Operation, Switch
from bspline_slam.edits.journal import Origin
from bspline_slam.errors import EditError, as_sentence
from bspline_slam.scan import ScanLog
from splinescope.activity import Activity, Work, stage_in_words
from splinescope.computing import edit_messages as told
from splinescope.computing.messages import Failed, Message, Progress, Stopped
from splinescope.edits.amending import amended_result
from splinescope.edits.answering import Answering, Show
from splinescope.edits.chronicle import Chronicle
from splinescope.edits.doubts import Doubts
from splinescope.edits.journals import Journals
from splinescope.edits.loop_draft import LoopDraft
from splinescope.edits.proposal import Picking, Proposal
from splinescope.edits.recent import Recent, State
from splinescope.edits.subject import name_of
from splinescope.notice import Notice
from splinescope.result import Result

NO_RUN = "Edits are made in the result of a finished run: show one first."
OFFERED = "There are edits from before: take them up, or set them aside, first."
MOMENT = 0.3
"""What takes no longer than this (s) is not told of while it goes on."""


class Editing:
    """State: the run that is edited, what was done in it, what is being proposed, and what the editor is asked for."""

    def __init__(
        self,
        editor: Answering,
        journals: Journals,
        show: Show,
        tell: Callable[[Notice], None],
        now: Callable[[], float] = time.time,
    ) -> None:
        self._editor, self._show, self._tell, self._now = editor, show, tell, now
        self._chronicle = Chronicle(journals)
        self._log: ScanLog | None = None
        self._jobs: dict[str, int] = {}
        self._glimpsed = 0
        self._in_map: tuple[Edit, ...] = ()
        self._settled_at = 0
        self._progress: Progress | None = None
        self._asked_at = 0.0
        self._recent = Recent()
        self.base: Result | None = None
        self.proposal: Proposal | None = None
        self.explanation: Explanation | None = None
        self.draft: LoopDraft | None = None
        self.picking: Picking | None = None
        self.doubts = Doubts()
        self._doubts_without: tuple[Doubt, ...] = ()

    # -- which run -----------------------------------------------------------------------------------------------
    def attend(self, log: ScanLog | None, shown: Result | None) -> None:
        """Look at what is shown: edits are about that, if it is a finished run."""
        if log is None or shown is None or not shown.editable:
            if shown is not None:
                self.leave()
            return
        if self.base is not None and self.base.number == shown.number and self._log is log:
            if not shown.edits:
                self.base = shown
            return
        self.close()
        self.base, self._log = shown, log
        config = shown.recipe.config()
        self._editor.cancel()
        self._jobs["prepare"] = self._editor.prepare(shown.kept, config)
        for notice in self._chronicle.open(Origin.of(log, config)):
            self._tell(notice)
        if self.history.entries:
            self._make()

    def close(self) -> None:
        """Leave the run; its journal is free for others."""
        self._chronicle.close()
        self._log, self.base, self.explanation, self._jobs, self._in_map = None, None, None, {}, ()
        self.doubts, self._doubts_without, self._recent, self._settled_at = Doubts(), (), Recent(), 0
        self.leave()

    @property
    def history(self) -> History:
        """What was done by hand in the run."""
        return self._chronicle.history

    @property
    def offer(self) -> History | None:
        """Edits from before that nobody has taken up yet."""
        return self._chronicle.offer

    @property
    def refusal(self) -> str | None:
        """What stands in the way of edits now; None if nothing does."""
        if self.base is None:
            return NO_RUN
        return OFFERED if self.offer is not None else None

    @property
    def making(self) -> bool:
        """Whether the map with the edits in force is on its way."""
        return "make" in self._jobs

    @property
    def activity(self) -> Activity | None:
        """The map being made with the edits in force, once that has taken a moment."""
        told, job = self._progress, self._jobs.get("make")
        if job is None:
            return None
        if told is not None and told.job == job:
            return Activity(Work.EDITING, job, stage_in_words(told.stage), told.fraction, told.seconds_left)
        return Activity(Work.EDITING, job, Work.EDITING.value) if self._now() - self._asked_at > MOMENT else None

    @property
    def no_doubts(self) -> str | None:
        """A sentence on why no decision is in the queue of doubts; None if one is."""
        if self.doubts.queue:
            return None
        if self.base is None:
            return "Close decisions are sought in the result of a finished run."
        if any(what in self._jobs for what in ("prepare", "make", "doubts")):
            return "Close decisions are being sought …"
        return "No doubtful decision is left." if self.doubts.right else "No decision was close enough to be doubted."

    @property
    def next_id(self) -> int:
        """The id that the next spline made by hand gets: one that no edit ever had."""
        edits = [e for entry in self.history.entries if isinstance(entry, Accepted) for e in entry.action.edits]
        return max((made + 1 for edit in edits for made in splines_made(edit)), default=FIRST_MADE_BY_HAND)

    # -- proposing -----------------------------------------------------------------------------------------------
    def propose(self, edits: tuple[Edit, ...]) -> None:
        """Look at what edits would do, before they are accepted."""
        if self._refused("Nothing was proposed"):
            return
        self.proposal, self.picking = Proposal(edits, name_of(edits)), None
        self._jobs["preview"] = self._editor.preview(self.history.active, edits)

    def leave(self) -> bool:
        """Let go of what is proposed, drafted or picked; whether there was anything."""
        busy = bool(self.proposal or self.picking or self.draft)
        self.proposal = self.picking = self.draft = None
        self._jobs.pop("preview", None)
        return busy

    def accept(self) -> None:
        """Make the proposed edits: first in the journal, then in the map."""
        proposal = self.proposal
        if proposal is None:
            self._tell(Notice("Nothing to accept", "Propose an edit first."))
        elif proposal.preview is not None and proposal.preview.refusal is not None:
            self._tell(Notice("Nothing was accepted", proposal.preview.refusal))
        else:
            self.leave()
            self._do(Accept(proposal.name, self._now(), proposal.edits))
            if self.making and proposal.preview is not None and proposal.preview.ghost is not None:
                self._show.glimpse(proposal.preview.ghost)
                self._glimpsed = self._jobs["make"]

    # -- history -------------------------------------------------------------------------------------------------
    def undo(self) -> None:
        """Take back the last action."""
        self._go(self.history.undo, "Nothing to undo", "The map is as the estimator made it.")

    def redo(self) -> None:
        """Do again what was taken back."""
        self._go(self.history.redo, "Nothing to redo", "Nothing was taken back.")

    def go_to(self, cursor: int) -> None:
        """Go to the state after so many actions."""
        self._do(GoTo(cursor))

    def switch(self, number: int, on: bool | None = None) -> None:
        """Put an action out of force or into force again; None changes to the other."""
        state = self.history.states.get(number)
        if state is None:
            self._tell(Notice("Nothing was switched", "This action is not in force: redo it first."))
        else:
            self._do(Switch(number, not state if on is None else on, self._now()))

    def _go(self, operation: GoTo | None, title: str, sentence: str) -> None:
        if operation is None:
            self._tell(Notice(title, sentence))
        else:
            self._do(operation)

    def _do(self, operation: Operation) -> None:
        if self._refused("Nothing was changed"):
            return
        before = self.history
        try:
            self._chronicle.append(operation)
        except EditError as error:
            self._tell(Notice("Nothing was changed", as_sentence(str(error)), bad=True))
            return
        self.proposal = None
        if self.history.active != before.active:
            self._make()

    def _refused(self, title: str) -> bool:
        if self.refusal is not None:
            self._tell(Notice(title, self.refusal))
        return self.refusal is not None

    def take_up(self, on: bool) -> None:
        """Go on with the edits from before, or set them aside and begin anew."""
        if self.offer is None:
            return
        if on:
            self._chronicle.take_up()
            self._make()
            return
        try:
            kept = self._chronicle.set_aside()
        except EditError as error:
            self._tell(Notice("The edits stay", as_sentence(str(error)), bad=True))
        else:
            self._tell(Notice("The edits are set aside", f"They are kept in {kept}."))

    def stop(self) -> None:
        """Leave off making the map: back to the last state that was there, from which redo leads on."""
        if not self.making:
            self._tell(Notice("Nothing to cancel", "No edit is being made."))
            return
        self._tell(Notice("Making the edits was stopped", "The map is as it was before; redo makes it after all."))
        before = min(self._settled_at, max(self.history.cursor - 1, 0))
        self._do(GoTo(before))

    def _make(self) -> None:
        """Ask for the map with the edits in force; one that was shown lately is there at once, and so is that without
        edits."""
        self._editor.cancel()
        edits, base = self.history.active, self.base
        known = self._recent.find(edits) if edits or base is None else State(base, None, self._doubts_without)
        for what in ("doubts", "make", "hand over"):
            self._jobs.pop(what, None)
        self._progress, self._asked_at = None, self._now()
        if known is None or known.doubts is None:
            self.explanation = None
            self._jobs["make"] = self._editor.make(edits, self._in_map)
        else:
            self.doubts = self.doubts.of(known.doubts)
            self._take(known)

    def _take(self, state: State) -> None:
        """From now on this is shown."""
        self._in_map, self.explanation = state.result.edits, state.explanation
        self._settled_at = self.history.cursor
        self._show.amend(state.result)
        if state.result.edits:
            self._jobs["hand over"] = self._editor.hand_over(state.result.edits)

    # -- loop closures -------------------------------------------------------------------------------------------
    def begin_draft(self, draft: LoopDraft) -> None:
        """Lay one key scan over another, to close a loop by hand."""
        if not self._refused("Nothing was begun"):
            self.leave()
            self.draft = draft

    def move_draft(self, draft: LoopDraft) -> None:
        """The ghost scan somewhere else."""
        self.draft, self.proposal = draft, None

    def match_draft(self) -> None:
        """Let the scan matcher place the ghost scan exactly, and propose the closure."""
        if self.draft is None:
            self._tell(Notice("Nothing to match", "Choose two key scans first."))
            return
        draft = self.draft
        self._jobs["match"] = self._editor.match(self.history.active, draft.earlier, draft.scan, draft.guess)

    # -- listening -----------------------------------------------------------------------------------------------
    def receive(self, message: Message) -> None:
        """Take in what the editor sent; messages of jobs that nobody waits for any more are dropped."""
        what = next((what for what, job in self._jobs.items() if job == message.job), None)
        if what is None:
            if isinstance(message, Failed):
                self._tell(Notice("The editor failed", message.sentence, bad=True))
            return
        match message:
            case Progress():
                self._progress = message
            case told.PreviewFound(preview=preview) if self.proposal is not None:
                self.proposal = replace(self.proposal, preview=preview)
            case told.QuickAnswer(ghost=ghost) if message.job != self._glimpsed:
                self._show.glimpse(ghost)
            case told.DoubtsFound(doubts=doubts):
                if what == "prepare":
                    self._doubts_without = doubts
                else:
                    self._recent.learn(self.history.active, doubts)
                self.doubts = self.doubts.of(doubts)
                del self._jobs[what]
            case told.EditsMade():
                self._jobs["doubts"] = self._jobs.pop(what)
                self._made(message)
            case told.Handed(edits=edits, amended=amended):
                del self._jobs[what]
                if self.base is not None:
                    self._show.handed(self.base.number, edits, amended)
            case told.LoopMatched():
                del self._jobs[what]
                self._matched(message)
            case Failed(sentence=sentence):
                self._failed(what, sentence)
            case Stopped():
                del self._jobs[what]

    def _made(self, made: told.EditsMade) -> None:
        if self.base is None:
            return
        state = State(amended_result(self.base, self.history.active, made), made.explanation)
        self._recent.keep(state)
        self._take(state)

    def _matched(self, found: told.LoopMatched) -> None:
        matched = self.draft.matched(found) if self.draft is not None else None
        if matched is None:
            return
        self.draft, close = matched
        self.proposal = Proposal((close,), name_of((close,)))
        self._jobs["preview"] = self._editor.preview(self.history.active, (close,))

    def _failed(self, what: str, sentence: str) -> None:
        """The process may be gone: the next one has to be made ready again."""
        self._jobs = {}
        self._tell(Notice("The edit failed" if what != "prepare" else "The editor failed", sentence, bad=True))
        if self.base is not None and "ended" in sentence:
            self._jobs["prepare"] = self._editor.prepare(self.base.kept, self.base.recipe.config())
            if self.history.active:
                self._jobs["make"] = self._editor.make(self.history.active, self._in_map)
