"""Actions of hand edits."""

from __future__ import annotations

from collections.abc import Callable

from splinescope import commands as ask
from splinescope.actions.action import Action, with_log
from splinescope.edits.proposal import Picking
from splinescope.edits.subject import EditKind
from splinescope.lost_scans import next_lost
from splinescope.session import Session

Refusal = Callable[[Session], str | None]
NO_POSE = "Select a key pose, or a segment of a key scan, first."
NOTHING_PROPOSED = "Propose an edit first."


def _refusal(kind: EditKind) -> Refusal:
    return lambda session: session.edit_refusal(kind)


def _proposed(session: Session) -> str | None:
    return None if session.editing.proposal is not None else NOTHING_PROPOSED


def _targets(session: Session) -> str | None:
    return None if session.subject.targets else "Nothing is selected that could be given to a spline."


def _pieces(session: Session) -> str | None:
    return None if len(session.subject.pieces) > 1 else "What is selected has no other piece."


def _posed(session: Session) -> str | None:
    return session.editing.refusal or (None if session.subject.scan is not None else NO_POSE)


def _undo(session: Session) -> str | None:
    return session.editing.refusal or (None if session.editing.history.undo else "There is nothing to undo.")


def _redo(session: Session) -> str | None:
    return session.editing.refusal or (None if session.editing.history.redo else "There is nothing to redo.")


def _offered(session: Session) -> str | None:
    return None if session.editing.offer is not None else "There are no edits from before."


def _drafted(session: Session) -> str | None:
    return None if session.editing.draft is not None else "Lay one key scan over another first."


def _of(name: str, kind: EditKind, words: str, *keys: str) -> Action:
    return Action(f"edit-{name}", words, keys, ask.EditSelected(kind), _refusal(kind))


STEP, TURN = 0.1, 0.0175
"""How far (m, rad) one press moves the ghost scan."""


def _ghost(name: str, words: str, key: str, x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> Action:
    return Action(f"ghost-{name}", words, (key,), ask.MoveGhost(x, y, turn), _drafted, repeats=True)


EDITING = (
    _of("force", EditKind.FORCE, "Force the piece to the target spline", "e"),
    Action("edit-target", "Next target spline", ("t",), ask.ChooseTarget(1), _targets),
    Action("edit-target-back", "Target spline before", ("T",), ask.ChooseTarget(-1), _targets),
    Action("edit-pick", "Choose the target spline by a click", ("E",), ask.PickNext(Picking.TARGET), _targets),
    Action("edit-piece", "Next piece of the segment", ("v",), ask.NextPiece(1), _pieces),
    _of("forbid", EditKind.FORBID, "Forbid the piece its spline", "x"),
    _of("new", EditKind.NEW, "Make a new spline of the piece", "w"),
    _of("ignore", EditKind.IGNORE, "Ignore the piece", "Delete"),
    _of("split", EditKind.SPLIT, "Split the piece or the spline in the middle", "u"),
    Action("edit-split-at", "Split it where you click", ("U",), ask.PickNext(Picking.PLACE), _refusal(EditKind.SPLIT)),
    _of("merge", EditKind.MERGE, "Merge the spline with the target", "m"),
    _of("pin", EditKind.PIN, "Pin the pose or the spline where it is", "p"),
    Action("edit-loop", "Close a loop: choose the other key scan", ("y",), ask.PickNext(Picking.LOOP), _posed),
    _of("drop-loop", EditKind.DROP_LOOP, "Drop the selected loop closure", "Y"),
    Action("edit-accept", "Accept the proposed edit", ("Enter",), ask.AcceptEdits(), _proposed),
    Action("edit-cancel", "Cancel the proposed edit", (), ask.DropProposal(), _proposed),
    Action("undo", "Undo the last edit", ("Ctrl+z",), ask.Undo(), _undo),
    Action("redo", "Redo", ("Ctrl+Shift+z", "Ctrl+y"), ask.Redo(), _redo),
    Action("edits-take-up", "Go on with the edits from before", (), ask.TakeUpEdits(True), _offered),
    Action("edits-set-aside", "Set the edits from before aside", (), ask.TakeUpEdits(False), _offered),
)


def _doubts(session: Session) -> str | None:
    return session.editing.no_doubts


def _doubted(session: Session) -> str | None:
    return None if session.editing.doubts.current is not None else "Go to a doubtful decision first."


def _lost(session: Session) -> str | None:
    return None if session.lost_scans else "No scan was lost."


def _to_lost(session: Session) -> ask.Command:
    after = next_lost(session.lost_scans, session.cursor)
    return ask.Seek(session.cursor if after is None else after)


MARKS = {"key": "key scan", "new": "scan that started a spline", "loop": "loop closure", "gated": "gated-out match"}
MARK_KEYS = {"key": "k", "new": "n", "loop": "l", "gated": "g", "hand": "h"}


def _marks() -> tuple[Action, ...]:
    """To the next mark of each kind on the timeline, and to the one before."""
    out = []
    for kind, words in {**MARKS, "hand": "decision by hand"}.items():
        on, back = f"Alt+{MARK_KEYS[kind]}", f"Alt+Shift+{MARK_KEYS[kind]}"
        ahead, behind = ask.SeekMark(kind, 1), ask.SeekMark(kind, -1)
        out.append(Action(f"next-{kind}", f"Next {words}", (on,), ahead, with_log, repeats=True))
        out.append(Action(f"previous-{kind}", f"The {words} before", (back,), behind, with_log, repeats=True))
    return tuple(out)


FINDING = (
    Action("next-doubt", "Next doubtful decision", ("q",), ask.StepDoubt(1), _doubts, repeats=True),
    Action("previous-doubt", "The doubtful decision before", ("Q",), ask.StepDoubt(-1), _doubts, repeats=True),
    Action("doubt-right", "The decision is right: take it out of the queue", (";",), ask.SettleDoubt(True), _doubted),
    Action("doubt-overrule", "Overrule the doubtful decision", (":",), ask.SettleDoubt(False), _doubted),
    *_marks(),
    Action("next-lost", "Next stretch of lost scans", ("Alt+o",), _to_lost, _lost, repeats=True),
    Action("previous-lost", "The lost scan before", ("Alt+Shift+o",), ask.SeekMark("lost", -1), _lost, repeats=True),
)
GHOST = (
    _ghost("left", "Ghost scan to the left", "Ctrl+ArrowLeft", x=-STEP),
    _ghost("right", "Ghost scan to the right", "Ctrl+ArrowRight", x=STEP),
    _ghost("up", "Ghost scan up", "Ctrl+ArrowUp", y=STEP),
    _ghost("down", "Ghost scan down", "Ctrl+ArrowDown", y=-STEP),
    _ghost("turn-left", "Turn the ghost scan left", "Alt+ArrowLeft", turn=TURN),
    _ghost("turn-right", "Turn the ghost scan right", "Alt+ArrowRight", turn=-TURN),
    Action("ghost-match", "Let the scan matcher place the ghost scan", ("Ctrl+Enter",), ask.MatchGhost(), _drafted),
)
