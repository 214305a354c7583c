"""The inspector: what the selected thing is, its numbers and its history."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.inspector import Description, describe
from splinescope.panels.action_button import ActionButton
from splinescope.panels.panel import Post
from splinescope.session import Session

HINT = "Click a segment, a curve, a control point or a key pose in the map to see what it is. Press ? for the keys."


class InspectorPanel:
    """Shows one thing at a time."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._text = gui.add_html(table.block(table.paragraph(HINT, "dim")))
        self._clear = ActionButton(gui, post, "leave", words="Clear the selection")
        self._steps = ActionButton(gui, post, "observation", words="Step through its observation")

    def refresh(self, session: Session) -> None:
        self._clear.handle.visible = session.selection is not None
        self._steps.handle.visible = can_be_observed(session)
        if session.selection is None:
            self._text.content = table.block(table.paragraph(HINT, "dim"))
            return
        found = describe(session.selection, session.scan_view, session.map_view, session.findings.steps)
        self._text.content = table.block(*parts(found))


def can_be_observed(session: Session) -> bool:
    """Whether a segment of a key scan is selected and is not being stepped through yet."""
    chosen, scan = session.selection, session.scan_view
    return not session.observing and chosen is not None and chosen.kind == "segment" and scan is not None and scan.key


def parts(found: Description) -> list[str]:
    """A description as HTML parts."""
    out = [table.heading(found.title), table.paragraph(found.sentence)]
    if found.rows:
        out.append(table.pairs(found.rows))
    if found.history:
        out += [table.heading("History"), table.bullets(found.history)]
    return out
