"""The lost scans: how many, which, what was done instead, and the way to them."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.commands import Seek
from splinescope.lost_scans import lost_in_words, next_lost
from splinescope.panels.panel import Post, on_press
from splinescope.session import Session

TITLE = "Lost scans"


class LostPanel:
    """A sentence under a heading that counts, and a button from one stretch of lost scans to the next."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._next = 0
        self._folder = gui.add_folder(TITLE, expand_by_default=False)
        with self._folder:
            self._text = gui.add_html("")
            self._go = gui.add_button("Go to the next lost scan", icon=viser.Icon.TARGET, visible=False)
        on_press(self._go, lambda: post(Seek(self._next)))

    def refresh(self, session: Session) -> None:
        lost = lost_scans(session)
        self._folder.label = f"{TITLE}: {f'{len(lost):,}' if lost else 'none'}" if session.findings.steps else TITLE
        self._text.content = table.block(table.paragraph(said(session, lost)))
        after = next_lost(lost, session.cursor)
        self._next, self._go.visible = after or 0, after is not None


def lost_scans(session: Session) -> list[int]:
    """Indices of the scans lost so far, increasing."""
    return sorted(step.scan for step in session.findings.steps.values() if step.lost)


def said(session: Session, lost: list[int]) -> str:
    """What there is to say of them."""
    if session.log is None:
        return "No log is open."
    if not session.findings.steps:
        return "No scan is processed yet."
    return lost_in_words(lost, session.log.odometry is not None) + (" They are marked on the timeline." if lost else "")
