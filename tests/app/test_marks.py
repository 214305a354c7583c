"""Marks on the timeline are found and led to."""

from __future__ import annotations

from app.desk import Desk
from splinescope import commands as ask
from splinescope.edits.subject import EditKind
from splinescope.marks import marks


def test_marks_tell_where_a_hand_decided_and_keys_lead_there(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    found = {(mark.kind, mark.position) for mark in marks(desk.session.findings)}
    assert ("hand", 11) in found
    assert {kind for kind, _ in found} >= {"key", "new", "hand"}
    desk.do(ask.Seek(3), ask.SeekMark("hand", 1))
    assert desk.session.cursor == 11
    desk.do(ask.SeekMark("hand", 1))
    assert "No such mark" in [notice.title for notice in desk.session.notices]
