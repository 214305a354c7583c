"""Edit: overrule the estimator by hand, take it back, see what the solver made of it, find what to look at."""

from __future__ import annotations

import viser

from bspline_slam.edits.edit import in_words
from splinescope import table
from splinescope.panels import edit_lists
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post
from splinescope.session import Session

OFFER: Buttons = {"Go on with these edits": "edits-take-up", "Set them aside": "edits-set-aside"}
EDITS: dict[str, Buttons] = {
    "Piece": {
        "Force to target": "edit-force",
        "Forbid spline": "edit-forbid",
        "New spline": "edit-new",
        "Ignore": "edit-ignore",
        "Next piece": "edit-piece",
    },
    "Target": {"Next": "edit-target", "Click it": "edit-pick", "Merge": "edit-merge"},
    "Split": {"In the middle": "edit-split", "At a click": "edit-split-at"},
    "Pose": {"Pin": "edit-pin", "Close a loop": "edit-loop", "Drop the loop": "edit-drop-loop"},
}
UNDO: Buttons = {"Undo": "undo", "Redo": "redo"}
DOUBT: Buttons = {
    "Next": "next-doubt",
    "Before": "previous-doubt",
    "It is right": "doubt-right",
    "Overrule": "doubt-overrule",
}


class EditPanel:
    """The edits that what is selected allows, the history, the doubtful decisions, and what the solver did."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._edits = gui.add_html("")
        with gui.add_folder("Doubtful decisions"):
            self._doubts = gui.add_html("")
        with gui.add_folder("What the solver did"):
            self._explanation = gui.add_html("")

    def refresh(self, session: Session) -> None:
        self._edits.content = table.block(*offer(session), *edits(session), *history(session))
        self._doubts.content = table.block(action_row(session, DOUBT), *edit_lists.doubted(session.editing))
        self._explanation.content = table.block(*explained(session))


def offer(session: Session) -> list[str]:
    """Edits from before, or why nothing can be edited."""
    editing = session.editing
    if editing.offer is not None:
        said = table.paragraph(f"{len(editing.offer.active)} edits were made in this result before.", "ask")
        return [said, action_row(session, OFFER, strong="edits-take-up")]
    return [table.paragraph(editing.refusal, "dim")] if editing.refusal is not None else []


def edits(session: Session) -> list[str]:
    """What can be done with what is selected."""
    rows = (action_row(session, buttons, label=label) for label, buttons in EDITS.items())
    return [*edit_lists.selected(session), *rows]


def history(session: Session) -> list[str]:
    """Undo, redo and every action."""
    told = session.editing.history
    return [action_row(session, UNDO, label="History"), *edit_lists.history(told), *edit_lists.verdict(session.editing)]


def explained(session: Session) -> list[str]:
    """What became of the edits in force, or what is being done about them."""
    editing = session.editing
    if editing.explanation is None:
        return [table.paragraph(edit_lists.ON_ITS_WAY if editing.making else "No edit is in force.", "dim")]
    return edit_lists.explanation(editing.explanation, tuple(map(in_words, editing.history.active)))
