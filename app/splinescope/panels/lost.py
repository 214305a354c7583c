"""The lost scans: how many, which, what was done instead, and the way to them."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.lost_scans import lost_in_words
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post
from splinescope.session import Session

TITLE = "Lost scans"
WAYS: Buttons = {"Next": "next-lost", "Before": "previous-lost"}


class LostPanel:
    """A sentence under a heading that counts, and a button from one stretch of lost scans to the next."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._folder = gui.add_folder(TITLE, expand_by_default=False)
        with self._folder:
            self._text = gui.add_html("")

    def refresh(self, session: Session) -> None:
        lost = session.lost_scans
        self._folder.label = f"{TITLE}: {f'{len(lost):,}' if lost else 'none'}" if session.findings.steps else TITLE
        buttons = [action_row(session, WAYS)] if lost else []
        self._text.content = table.block(table.paragraph(said(session, lost)), *buttons)


def said(session: Session, lost: list[int]) -> str:
    """What there is to say of them."""
    if session.log is None:
        return "No log is open."
    if not session.findings.steps:
        return "No scan is processed yet."
    return lost_in_words(lost, session.log.odometry is not None) + (" They are marked on the timeline." if lost else "")
