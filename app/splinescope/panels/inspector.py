"""What it is about, always in sight: the proposed edit, else the ruler, else what is selected, with its buttons."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.inspector import Description, describe
from splinescope.panels import edit_lists
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post
from splinescope.panels.ruler import reading
from splinescope.session import Session

HINT = "Click a segment, a curve, a control point or a key pose in the map to see what it is. Press ? for the keys."
ACCEPT: Buttons = {"Accept ⏎": "edit-accept", "Cancel Esc": "leave"}
MATCH: Buttons = {"Match it": "ghost-match", "Cancel Esc": "leave"}
PICK: Buttons = {"Cancel Esc": "leave"}
RULER: Buttons = {"Put the ruler away": "leave"}
CHOSEN: Buttons = {"Clear": "leave", "Measure": "measure"}
SEGMENT: Buttons = {"Clear": "leave", "Its observation": "observation", "Measure": "measure"}
NOTHING: Buttons = {"Measure between two things": "measure"}


class InspectorPanel:
    """Shows one thing at a time; as tall for each, so that what is below stays where it is."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._text = gui.add_html(table.block(table.paragraph(HINT, "dim")))

    def refresh(self, session: Session) -> None:
        self._text.content = table.block(*shown(session))


def shown(session: Session) -> list[str]:
    """The thing in question and what can be done with it, as HTML parts."""
    editing = session.editing
    if editing.proposal is not None:
        return framed(edit_lists.proposed(editing), action_row(session, ACCEPT, strong="edit-accept"))
    if editing.draft is not None:
        return framed(edit_lists.proposed(editing), action_row(session, MATCH, strong="ghost-match"))
    if editing.picking is not None:
        return framed(edit_lists.proposed(editing), action_row(session, PICK))
    if session.ruler is not None:
        return framed(reading(session.ruler), action_row(session, RULER))
    if session.selection is None:
        return [table.paragraph(HINT, "dim"), action_row(session, NOTHING)]
    found = describe(session.selection, session.scan_view, session.map_view, session.findings.steps)
    return framed(parts(found), action_row(session, SEGMENT if session.selection.kind == "segment" else CHOSEN))


def framed(text: list[str], buttons: str) -> list[str]:
    """A text that is scrolled where it is long, above buttons that stay."""
    return [f'<div class="peek"><div tabindex="0">{"".join(text)}</div>{buttons}</div>']


def parts(found: Description) -> list[str]:
    """A description as HTML parts."""
    out = [table.heading(found.title)]
    if found.decisions:
        out.append(table.bullets(found.decisions))
    else:
        out.append(table.paragraph(found.sentence))
    if found.rows:
        out.append(table.pairs(found.rows))
    if found.decisions:
        out.append(table.paragraph(found.sentence, "dim"))
    if found.history:
        out += [table.heading("History"), table.bullets(found.history)]
    return out
