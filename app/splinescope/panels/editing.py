"""Edit: overrule the estimator by hand, see what that would do, accept it, take it back."""

from __future__ import annotations

import viser

from bspline_slam.edits.edit import in_words
from splinescope import table
from splinescope.actions import Perform
from splinescope.commands import TakeUpEdits
from splinescope.panels import edit_lists
from splinescope.panels.panel import Post, on_choice, on_press
from splinescope.session import Session

Buttons = dict[str, str]
"""Buttons side by side: what they say, and the action that they ask for."""

ACCEPT: Buttons = {"Accept ⏎": "edit-accept", "Cancel Esc": "leave"}
MATCH: Buttons = {"Match it": "ghost-match", "Cancel Esc": "leave"}
EDITS: dict[str, Buttons] = {
    "Association": {"Force to target": "edit-force", "Forbid spline": "edit-forbid"},
    "No match": {"New spline": "edit-new", "Ignore": "edit-ignore"},
    "Target": {"Next": "edit-target", "Click it": "edit-pick", "Merge": "edit-merge"},
    "Split": {"In the middle": "edit-split", "At a click": "edit-split-at"},
    "Pin": {"Pin": "edit-pin", "Next piece": "edit-piece"},
    "Loop closure": {"Close": "edit-loop", "Drop": "edit-drop-loop"},
}
DOUBT: Buttons = {"Next": "next-doubt", "Before": "previous-doubt"}
SETTLE: Buttons = {"Right": "doubt-right", "Overrule": "doubt-overrule"}
UNDO: Buttons = {"Undo": "undo", "Redo": "redo"}


class EditPanel:
    """The proposal, what is selected with the edits that it allows, the history, and what the solver did."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._gui, self._post = gui, post
        self._head = gui.add_html("")
        self._take_up = gui.add_button("Go on with these edits", visible=False)
        self._set_aside = gui.add_button("Set them aside and begin anew", color="gray", visible=False)
        on_press(self._take_up, lambda: post(TakeUpEdits(True)))
        on_press(self._set_aside, lambda: post(TakeUpEdits(False)))
        self._accept, self._match = self._row("Proposal", ACCEPT), self._row("Ghost scan", MATCH)
        self._selected = gui.add_html("")
        for label, buttons in EDITS.items():
            self._row(label, buttons)
        with gui.add_folder("Doubtful decisions"):
            self._row("Go to the", DOUBT)
            self._row("It is", SETTLE)
            self._doubts = gui.add_html("")
        with gui.add_folder("History"):
            self._row("Last action", UNDO)
            self._history = gui.add_html("")
        with gui.add_folder("What the solver did"):
            self._explanation = gui.add_html("")

    def _row(self, label: str, actions: Buttons) -> viser.GuiButtonGroupHandle:
        """Buttons side by side; one that can do nothing now says why when it is pressed."""
        group = self._gui.add_button_group(label, tuple(actions))
        on_choice(group, lambda words: self._post(Perform(actions[words])))
        return group

    def refresh(self, session: Session) -> None:
        editing = session.editing
        self._head.content = table.block(*offer(session), *edit_lists.proposed(editing))
        self._take_up.visible = self._set_aside.visible = editing.offer is not None
        self._accept.visible = editing.proposal is not None
        self._match.visible = editing.draft is not None and editing.proposal is None
        self._selected.content = table.block(*edit_lists.selected(session))
        self._doubts.content = table.block(*edit_lists.doubted(editing.doubts))
        self._history.content = table.block(*edit_lists.history(editing.history), *edit_lists.switches(editing.history))
        self._explanation.content = table.block(*explained(session))


def offer(session: Session) -> list[str]:
    """Edits from before, or why nothing can be edited."""
    editing = session.editing
    if editing.offer is not None:
        return [table.paragraph(f"{len(editing.offer.active)} edits were made in this result before.", "ask")]
    return [table.paragraph(editing.refusal, "dim")] if editing.refusal is not None else []


def explained(session: Session) -> list[str]:
    """What became of the edits in force, or what is being done about them."""
    editing = session.editing
    if editing.making:
        return [table.paragraph("The exact map is on its way; what you see is nearly it.", "dim")]
    if editing.explanation is None:
        return [table.paragraph("No edit is in force.", "dim")]
    return edit_lists.explanation(editing.explanation, tuple(map(in_words, editing.history.active)))
