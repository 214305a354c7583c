"""Hand edits are kept, and gone on with."""

from __future__ import annotations

from pathlib import Path

from app.desk import LOG, Desk
from bspline_slam.edits.history import History
from bspline_slam.edits.journal import read_journal
from splinescope import commands as ask
from splinescope.computing.messages import (
    Message,
)
from splinescope.edits.subject import EditKind


def test_an_accepted_edit_is_in_the_journal_before_it_is_answered(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE))
    desk.session.apply(ask.AcceptEdits())
    assert read_journal(desk.journal).history.active == desk.editing.history.active != ()
    assert desk.editing.making
    desk.editor.answer()
    assert not desk.editing.making
    assert desk.editing.explanation is not None
    assert desk.session.result is not None and desk.session.result.edits == desk.editing.history.active


def test_reopening_gives_every_accepted_edit(desk: Desk, tmp_path: Path, sample_run: list[Message]) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    desk.select(12)
    desk.do(ask.EditSelected(EditKind.SPLIT), ask.AcceptEdits(), ask.EditSelected(EditKind.PIN))
    shown, history = desk.shown, desk.editing.history
    desk.editing.close()
    again = Desk(tmp_path, sample_run)
    assert (again.shown, again.editing.history) == (shown, history)


def test_edits_from_before_are_offered_and_can_be_set_aside(tmp_path: Path, sample_run: list[Message]) -> None:
    first = Desk(tmp_path, sample_run, offered=True)
    first.select()
    first.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    shown = first.shown
    first.editing.close()
    again = Desk(tmp_path, sample_run, offered=True)
    assert again.editing.offer is not None and again.editing.history == History()
    again.do(ask.EditSelected(EditKind.IGNORE))
    assert again.editing.proposal is None
    again.do(ask.TakeUpEdits(True))
    assert again.shown == shown
    again.editing.close()
    anew = Desk(tmp_path, sample_run, offered=True)
    anew.do(ask.TakeUpEdits(False))
    assert anew.editing.history == History() and anew.editing.refusal is None
    assert len(anew.journals) == 1
    anew.select()
    anew.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    assert len(anew.journals) == 2


def test_a_damaged_journal_is_told_and_not_touched(desk: Desk, tmp_path: Path, sample_run: list[Message]) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits(), ask.Undo())
    desk.editing.close()
    lines = desk.journal.read_bytes().replace(b"Ignore", b"Ignone", 1)
    desk.journal.write_bytes(lines)
    again = Desk(tmp_path, sample_run)
    assert any("damaged" in trouble for trouble in again.session.troubles)
    assert again.journal.read_bytes() == lines


def test_edits_go_with_a_log_that_moved(desk: Desk, tmp_path: Path, sample_run: list[Message]) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    history = desk.editing.history
    desk.editing.close()
    moved = tmp_path / "elsewhere.log.gz"
    moved.write_bytes(LOG.read_bytes())
    assert Desk(tmp_path, sample_run, log=moved).editing.history == history
