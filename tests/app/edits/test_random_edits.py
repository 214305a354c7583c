"""Random operations: the same edits show the same, however they came about."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from app.desk import AtOnce, Desk
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    PinPose,
)
from bspline_slam.edits.journal import read_journal
from bspline_slam.slam import Snapshot
from splinescope import commands as ask
from splinescope.computing.edit_messages import (
    EditsMade,
    FindPreview,
    MakeEdits,
    Preview,
    PreviewFound,
)
from splinescope.computing.messages import (
    Message,
)
from splinescope.edits.subject import EditKind
from splinescope.view import Selection


def edits_on(desk: Desk) -> list[Edit]:
    """An edit of each simple kind on many key scans."""
    out: list[Edit] = []
    for scan in sorted(desk.session.findings.steps):
        piece = desk.piece(scan)
        assert piece.spline is not None
        where = (piece.scan, piece.segment, piece.first, piece.last)
        pose = tuple(desk.session.findings.pose(scan).tolist())
        out += [Ignore(*where), Forbid(*where, piece.spline), Force(*where, piece.spline), PinPose(scan, pose)]
        out.append(MakeNew(*where, FIRST_MADE_BY_HAND + scan))
    return out


class QuickAndWrong(AtOnce):
    """Makes of edits a map that differs for different edits, in no time."""

    base: Snapshot

    def answer(self) -> None:
        asked, self.asked = self.asked, []
        for request in asked:
            if isinstance(request, FindPreview):
                self.hear(PreviewFound(request.job, Preview(final=True)))
            if isinstance(request, MakeEdits):
                aside = int(hashlib.sha256(repr(request.edits).encode()).hexdigest()[:8], 16) / 2**32
                poses = self.base.poses + np.array([aside, 0.0, 0.0])
                self.hear(EditsMade(request.job, replace(self.base, poses=poses), {}, None, None))


def test_300_random_operations_undone_give_the_first_hash_and_redone_the_last(
    tmp_path: Path, sample_run: list[Message]
) -> None:
    desk = Desk(tmp_path, sample_run)
    editor = QuickAndWrong(desk.session.hear)
    assert desk.session.findings.snapshot is not None
    editor.base, desk.editor = desk.session.findings.snapshot, editor
    desk.editing._editor = editor
    rng, edits, first = np.random.default_rng(11), edits_on(desk), desk.shown
    for _ in range(300):
        history = desk.editing.history
        match rng.integers(0, 7):
            case 0 | 1 | 2:
                desk.do(ask.ProposeEdits((edits[rng.integers(len(edits))],)), ask.AcceptEdits())
            case 3:
                desk.do(ask.Undo())
            case 4:
                desk.do(ask.Redo())
            case 5 if history.states:
                desk.do(ask.SwitchEdit(int(rng.choice(list(history.states)))))
            case _:
                desk.do(ask.GoToEdit(int(rng.integers(len(history.entries) + 1))))
    history = desk.editing.history
    desk.do(ask.GoToEdit(len(history.entries)))
    last = desk.shown
    for _ in history.entries:
        desk.do(ask.Undo())
    assert desk.shown == first
    for _ in history.entries:
        desk.do(ask.Redo())
    assert desk.shown == last
    assert read_journal(desk.journal).history == desk.editing.history


class Operating(RuleBasedStateMachine):
    """A session under random commands, with the real editor: what is shown depends on the edits in force alone."""

    sample_run: list[Message]
    folders: Iterator[Path]

    def __init__(self) -> None:
        super().__init__()
        self.desk = Desk(next(self.folders), self.sample_run)
        self.edits = edits_on(self.desk)[:25]
        self.seen = {self.desk.editing.history.state_hash: self.desk.shown}

    @rule(data=st.data(), accepted=st.booleans())
    def propose(self, data: st.DataObject, accepted: bool) -> None:
        before = self.desk.shown
        self.desk.do(ask.ProposeEdits((data.draw(st.sampled_from(self.edits)),)))
        assert self.desk.shown == before
        self.desk.do(ask.AcceptEdits() if accepted else ask.Leave())

    @rule(command=st.sampled_from([ask.Undo(), ask.Redo(), ask.SwitchEdit(0), ask.SwitchEdit(1), ask.GoToEdit(1)]))
    def go(self, command: ask.Command) -> None:
        self.desk.do(command)

    @rule(scan=st.integers(0, 22), kind=st.sampled_from(EditKind), by=st.integers(-2, 2))
    def select_and_propose(self, scan: int, kind: EditKind, by: int) -> None:
        self.desk.do(
            ask.Seek(scan),
            ask.Select(Selection("segment", 0)),
            ask.ChooseTarget(by),
            ask.EditSelected(kind),
            ask.Leave(),
        )

    @rule()
    def reopen(self) -> None:
        history, shown = self.desk.editing.history, self.desk.shown
        folder = self.desk.folder
        self.desk.editing.close()
        self.desk = Desk(folder, self.sample_run)
        assert (self.desk.editing.history, self.desk.shown) == (history, shown)

    @invariant()
    def the_same_edits_show_the_same(self) -> None:
        assert not self.desk.editing.making
        found = self.seen.setdefault(self.desk.editing.history.state_hash, self.desk.shown)
        assert self.desk.shown == found

    def teardown(self) -> None:
        self.desk.editing.close()


def test_a_session_under_random_operations(tmp_path_factory: pytest.TempPathFactory, sample_run: list[Message]) -> None:
    from hypothesis.stateful import run_state_machine_as_test

    Operating.sample_run = sample_run
    Operating.folders = (tmp_path_factory.mktemp("edits") for _ in itertools.count())
    run_state_machine_as_test(Operating, settings=settings(max_examples=6, stateful_step_count=10, deadline=None))
