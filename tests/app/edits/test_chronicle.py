"""Hand edits are kept, and gone on with."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

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


def test_what_cannot_be_kept_is_a_sentence_and_nothing_is_changed(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    kept, shown = desk.editing.history, desk.shown
    desk.journal.unlink()
    desk.do(ask.Undo())
    assert (desk.editing.history, desk.shown) == (kept, shown)
    assert (desk.session.notices[-1].title, desk.session.notices[-1].bad) == ("Nothing was changed", True)
    assert "has been removed" in desk.session.notices[-1].text


def test_edits_that_cannot_be_set_aside_are_still_offered(
    tmp_path: Path, sample_run: list[Message], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = Desk(tmp_path, sample_run, offered=True)
    first.select()
    first.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    first.editing.close()
    again = Desk(tmp_path, sample_run, offered=True)
    with monkeypatch.context() as unwritable:
        unwritable.setattr(Path, "rename", _read_only)
        again.do(ask.TakeUpEdits(False))
    assert again.editing.offer is not None
    assert "cannot be set aside: Read-only file system" in again.session.notices[-1].text
    again.do(ask.TakeUpEdits(True))
    assert again.editing.history.active


def _read_only(path: Path, target: Path) -> Path:
    raise OSError(errno.EROFS, os.strerror(errno.EROFS))
