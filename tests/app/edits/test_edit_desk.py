"""What is selected, clicked or doubted is turned into edits."""

from __future__ import annotations

import numpy as np
import pytest

from app.desk import LOG, Desk, Idle, pieces
from bspline_slam.edits.doubts import Doubt
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    CloseLoop,
    Ignore,
    MakeNew,
    OnPiece,
)
from bspline_slam.logs import open_log
from splinescope import commands as ask
from splinescope.browser.preferences import Preferences
from splinescope.edits.proposal import Picking
from splinescope.edits.subject import EditKind
from splinescope.panels.inspector import shown
from splinescope.pieces import name_of_piece
from splinescope.session import Session
from splinescope.view import Selection


@pytest.mark.parametrize("kind", [EditKind.FORBID, EditKind.NEW, EditKind.IGNORE, EditKind.SPLIT, EditKind.PIN])
def test_edits_of_a_segment_are_made_and_taken_back(desk: Desk, kind: EditKind) -> None:
    first = desk.shown
    desk.select()
    desk.do(ask.EditSelected(kind), ask.AcceptEdits())
    assert desk.editing.explanation is not None
    last = desk.shown
    assert last != first
    desk.do(ask.Undo())
    assert desk.shown == first
    desk.do(ask.Redo())
    assert desk.shown == last
    desk.do(ask.SwitchEdit(0))
    assert desk.shown == first
    desk.do(ask.SwitchEdit(0))
    assert desk.shown == last
    desk.do(ask.GoToEdit(0))
    assert desk.shown == first


@pytest.mark.parametrize("kind", [EditKind.FORCE, EditKind.FORBID, EditKind.NEW, EditKind.IGNORE])
def test_several_pieces_are_edited_by_one_action(desk: Desk, kind: EditKind) -> None:
    first, every = desk.shown, pieces(desk)
    assert len(every) >= 2
    desk.do(ask.SelectPieces(every), ask.EditSelected(kind))
    proposal = desk.editing.proposal
    assert proposal is not None and f"{len(every)} pieces of scan 11" in proposal.name
    assert [(e.segment, e.first, e.last) for e in proposal.edits if isinstance(e, OnPiece)] == list(every)
    assert proposal.preview is not None and proposal.preview.final
    made = [e.spline for e in proposal.edits if isinstance(e, MakeNew)]
    assert made == list(range(FIRST_MADE_BY_HAND, FIRST_MADE_BY_HAND + len(made)))
    if proposal.preview.refusal is not None:
        return
    desk.do(ask.AcceptEdits())
    assert len(desk.editing.history.entries) == 1
    assert len(desk.editing.history.active) == len(every)
    assert desk.shown != first
    desk.do(ask.Undo())
    assert desk.shown == first


def test_shift_adds_pieces_and_takes_them_away(desk: Desk) -> None:
    a, b, *_ = pieces(desk)
    desk.do(ask.TogglePiece(b))
    assert desk.session.selection == Selection("segment", b[0])
    assert desk.session.subject.piece is not None and name_of_piece(desk.session.subject.piece) == b
    desk.do(ask.TogglePiece(a))
    assert desk.session.selection == Selection("pieces", 11, pieces=(a, b))
    assert "2 pieces selected" in "".join(shown(desk.session))
    assert desk.session.edit_refusal(EditKind.SPLIT) is not None
    desk.do(ask.TogglePiece(b))
    assert desk.session.selection == Selection("segment", a[0])
    desk.do(ask.TogglePiece(b), ask.Leave())
    assert desk.session.selection is None
    desk.do(ask.SelectPieces((a, b)), ask.Step(1))
    assert desk.session.selection is None


def test_pieces_of_a_scan_that_is_no_key_scan_are_not_selected() -> None:
    session, request = Session(Idle(), lambda _: None, Preferences()), ask.OpenLog(LOG)
    for command in (request, ask.LogOpened(request, open_log(LOG)), ask.SelectPieces(((0, 0, 9), (1, 10, 19)))):
        session.apply(command)
    assert session.scan_view is not None and not session.scan_view.key
    assert session.selection is None
    assert "Nothing was selected" in [notice.title for notice in session.notices]


def test_a_spline_is_split_and_merged_and_pinned(desk: Desk) -> None:
    spline = desk.piece().spline
    assert spline is not None
    desk.do(ask.Select(Selection("spline", spline)), ask.EditSelected(EditKind.SPLIT), ask.AcceptEdits())
    assert desk.session.map_view is not None and FIRST_MADE_BY_HAND in desk.session.map_view.map
    assert desk.editing.next_id == FIRST_MADE_BY_HAND + 1
    desk.do(ask.Select(Selection("spline", spline)), ask.ChooseTarget(spline=FIRST_MADE_BY_HAND), ask.AcceptEdits())
    assert FIRST_MADE_BY_HAND not in desk.session.map_view.map
    desk.do(ask.EditSelected(EditKind.PIN), ask.AcceptEdits())
    assert desk.editing.explanation is not None
    assert [outcome.fate.value for outcome in desk.editing.explanation.outcomes] == ["followed"] * 3


def test_clicks_choose_a_target_and_a_place(desk: Desk) -> None:
    spline = desk.piece().spline
    assert spline is not None and desk.session.map_view is not None
    x, y = desk.session.map_view.map[spline].sample(0.1)[1][20].tolist()
    desk.do(ask.Select(Selection("spline", spline)), ask.PickNext(Picking.PLACE))
    assert "Click the place" in desk.session.view.asks
    desk.do(ask.PickPlace(x, y, 0.1))
    assert desk.editing.picking is None
    proposal = desk.editing.proposal
    assert proposal is not None and proposal.name.startswith(f"Split spline {spline} at {x:.2f}, {y:.2f}")


def test_a_loop_is_closed_by_laying_one_scan_over_another(desk: Desk) -> None:
    world = desk.session.map_view
    assert world is not None
    first, last = world.key_poses[0], world.key_poses[-1]
    desk.do(ask.Select(Selection("key pose", world.key_scans[-1])), ask.PickNext(Picking.LOOP))
    desk.do(ask.PickPlace(float(first[0]), float(first[1]), 0.1))
    draft = desk.editing.draft
    assert draft is not None
    np.testing.assert_allclose(draft.pose, last, atol=1e-9)
    desk.do(ask.MoveGhost(0.1, 0.05, 0.02))
    assert desk.session.view.ghost is not None and desk.session.view.ghost.points is not None
    desk.do(ask.MatchGhost())
    proposal, draft = desk.editing.proposal, desk.editing.draft
    assert proposal is not None and draft is not None and draft.verdict.startswith("correlation")
    (close,) = proposal.edits
    assert isinstance(close, CloseLoop) and close.score > 0.3
    np.testing.assert_allclose(draft.pose, last, atol=0.15)
    desk.do(ask.AcceptEdits())
    assert desk.session.map_view is not None
    assert desk.session.map_view.loop_closures[-1].reason == "closed by hand"
    number = len(desk.session.map_view.loop_closures) - 1
    desk.do(ask.Select(Selection("closure", number)), ask.EditSelected(EditKind.DROP_LOOP), ask.AcceptEdits())
    assert not desk.session.map_view.loop_closures[-1].accepted


def test_what_cannot_be_done_says_why(desk: Desk) -> None:
    desk.do(ask.EditSelected(EditKind.FORCE), ask.Undo(), ask.Redo(), ask.AcceptEdits(), ask.SwitchEdit(3))
    told = {notice.title for notice in desk.session.notices}
    assert {"Nothing was proposed", "Nothing to undo", "Nothing to redo", "Nothing to accept"} <= told
    assert desk.journals == []
    for kind in EditKind:
        assert desk.session.edit_refusal(kind)


def test_doubtful_decisions_are_leafed_through_found_right_or_overruled(desk: Desk) -> None:
    editing, scan = desk.editing, desk.piece().scan
    piece = desk.piece()
    about = OnPiece(piece.scan, piece.segment, piece.first, piece.last)
    ignore = Ignore(piece.scan, piece.segment, piece.first, piece.last)
    other = Doubt(0.7, "another one", 5, OnPiece(5, 0, 0, 9))
    editing.doubts = editing.doubts.of((Doubt(0.9, "close", scan, about, overrule=(ignore,)), other))
    desk.do(ask.StepDoubt(1))
    assert desk.session.cursor == scan
    assert desk.session.selection == Selection("segment", piece.segment)
    desk.do(ask.SettleDoubt(False))
    assert editing.proposal is not None and editing.proposal.edits == (ignore,)
    desk.do(ask.Leave(), ask.SettleDoubt(True))
    assert [doubt.sentence for doubt in editing.doubts.queue] == ["another one"]
    assert desk.session.cursor == 5
    desk.do(ask.StepDoubt(-1), ask.StepDoubt(1), ask.ShowDoubt(0))
    assert editing.doubts.current is other
