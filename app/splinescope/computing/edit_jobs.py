"""What the editor's process does: preview edits, make them, match scans for a loop closure."""

from __future__ import annotations

import gc
import pickle
import time
from collections.abc import Callable

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.edits.amend import amended
from bspline_slam.edits.doubts import doubts
from bspline_slam.edits.edit import Edit, Ignore
from bspline_slam.edits.explain import costs, explain
from bspline_slam.edits.loop_match import match_loop
from bspline_slam.edits.making import decided
from bspline_slam.edits.quick import answer
from bspline_slam.edits.settling import settled
from bspline_slam.edits.states import States
from bspline_slam.errors import Cancelled, EditError
from bspline_slam.slam import SlamConfig, StageProgress
from splinescope.computing.edit_messages import (
    DoubtsFound,
    EditRequest,
    FindPreview,
    Ghost,
    Handed,
    HandOver,
    LoopMatched,
    MakeEdits,
    MatchLoop,
    Prepare,
    Preview,
    PreviewFound,
    QuickAnswer,
)
from splinescope.computing.ghosts import ghost_of
from splinescope.computing.handover import packed
from splinescope.computing.made import made_message
from splinescope.computing.messages import Message
from splinescope.computing.preview import Before, bent, preview, with_edits
from splinescope.computing.reporter import Reporter, failures_told

Edits = tuple[Edit, ...]
MOMENT = 0.3
"""What takes no longer than this (s) is not told of while it goes on."""


class Jobs:
    """Does one request after the other. State: the results with edits that are remembered of an automatic one, whose
    costs are at hand, and the edits that were looked at last with the ghost of what they do."""

    def __init__(self, send: Callable[[Message], None]) -> None:
        self._send = send
        self._states: States | None = None
        self._costs: dict[str, float] = {}
        self._looked_at: tuple[FindPreview, Ghost] | None = None

    def do(self, request: EditRequest, cancelled: Callable[[], bool]) -> None:
        """Do a request; whatever goes wrong in it is sent as a sentence."""
        with failures_told(request.job, self._send, "editor"):
            if isinstance(request, Prepare) or not cancelled():
                self._do(request, cancelled)

    def meanwhile(self, request: EditRequest, cancelled: Callable[[], bool]) -> bool:
        """Do a request in the middle of another one, if it is one that need not wait for that; whether it is."""
        at_once = isinstance(request, FindPreview | MatchLoop) and self._states is not None
        if at_once:
            self.do(request, cancelled)
        return at_once

    def _do(self, request: EditRequest, cancelled: Callable[[], bool]) -> None:
        match request:
            case Prepare(kept=kept, config=config):
                self._prepare(kept, config)
                self._send(DoubtsFound(request.job, doubts(self._known.base, config)))
            case FindPreview(in_force=in_force, proposed=proposed):
                preview(self._before(in_force), proposed, lambda p: self._tell_preview(request, p))
            case MakeEdits():
                self._make(request, cancelled)
            case HandOver(edits=edits):
                states = self._known
                made = amended(states.base, edits, states.config, cancelled=cancelled, states=states)
                self._send(Handed(request.job, edits, packed(states.base, made.snapshot)))
            case MatchLoop(in_force=in_force, earlier=earlier, scan=scan, guess=guess):
                found = match_loop(self._before(in_force).decisions, earlier, scan, guess, self._known.config)
                self._send(
                    LoopMatched(
                        request.job, found.measured, found.sqrt_information, found.score, found.inliers, found.sentence
                    )
                )

    def _prepare(self, kept: bytes, config: SlamConfig) -> None:
        """Get ready; what lasts as long as the result is not gone through again whenever memory is tidied."""
        self._states = self._looked_at = None
        gc.unfreeze()
        self._states = States(pickle.loads(kept), config)
        assert self._states.base.estimate is not None
        self._costs = costs(self._states.base.estimate)
        warm(self._states)
        gc.collect()
        gc.freeze()

    @property
    def _known(self) -> States:
        if self._states is None:
            raise EditError("the editor has lost the result that is to be edited")
        return self._states

    def _before(self, edits: Edits) -> Before:
        """What more edits are looked at from: the result with these, or the nearest one that is settled and the
        decisions from there on."""
        states = self._known
        nearest = states.nearest(edits)
        footing = states.footing(nearest)
        decisions, _ = decided(footing.ground, footing.ground.decisions, edits[len(nearest) :])
        return Before(footing, decisions, states[nearest].snapshot)

    def _tell_preview(self, request: FindPreview, found: Preview) -> None:
        if found.ghost is not None:
            self._looked_at = (request, found.ghost)
        self._send(PreviewFound(request.job, found))

    def _make(self, request: MakeEdits, cancelled: Callable[[], bool]) -> None:
        job, edits, states, start = request.job, request.edits, self._known, time.monotonic()
        self._glimpse(request)
        progress = slow(Reporter(job, self._send))
        made = amended(states.base, edits, states.config, progress, cancelled, states)
        told = explain(states.base, made.snapshot, edits, made.skipped, states.config, self._costs) if edits else None
        if cancelled():
            raise Cancelled("newer edits are on their way")
        self._send(made_message(job, states.base, made, told, time.monotonic() - start))
        if cancelled():
            raise Cancelled("newer edits are on their way")
        self._send(DoubtsFound(job, doubts(made.snapshot, states.config)))

    def _glimpse(self, request: MakeEdits) -> None:
        """The quick answer where there is none better: as it was looked at, or from the nearest result before."""
        job, edits, states = request.job, request.edits, self._known
        if self._looked_at is not None:
            asked, ghost = self._looked_at
            if asked.in_force == request.shown and (*asked.in_force, *asked.proposed) == edits:
                self._send(QuickAnswer(job, ghost))
                return
        if edits in states or request.shown not in states:
            return
        nearest = states.nearest(edits)
        footing, more = states.footing(nearest), edits[len(nearest) :]
        decisions, reason = with_edits(footing.ground, footing.ground.decisions, more)
        if reason is not None:
            return
        shown = states[request.shown].snapshot
        moved = bent(Before(footing, footing.ground.decisions, shown), more, decisions)
        found = moved or answer(footing, decisions, rounds=1).decisions
        self._send(QuickAnswer(job, ghost_of(shown, found)))


def warm(states: States) -> None:
    """Make an edit for nobody, so that the first one of a person finds everything loaded."""
    footing = states.footing(())
    ground, splines = footing.ground, {spline.id for spline in footing.ground.decisions.splines}
    piece = next((a for key in ground.decisions.keys for a in key.associations if a.spline in splines), None)
    if piece is not None:
        ignored = Ignore(piece.scan, piece.segment, piece.first, piece.last)
        decisions, _ = decided(ground, ground.decisions, (ignored,))
        answer(footing, decisions, rounds=1)
        settled(ground, decisions)


def slow(reporter: Reporter) -> StageProgress:
    """Tells progress of what takes longer than a moment."""
    start = time.monotonic()

    def progress(stage: str, fraction: float, record: IterationRecord | None) -> None:
        if time.monotonic() - start > MOMENT:
            reporter.progress(stage, fraction)

    return progress
