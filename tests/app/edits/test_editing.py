"""Hand edits in a session: proposed, made, measured; with the real editor's work, done at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.desk import FILE, Desk, pieces
from bspline_slam.edits.doubts import Doubt
from bspline_slam.edits.edit import (
    OnPiece,
)
from bspline_slam.spline_map import SplineMap
from splinescope import commands as ask
from splinescope.actions import ACTIONS
from splinescope.activity import Activity, Work
from splinescope.computing.edit_messages import (
    EditsMade,
    HandOver,
    PreviewFound,
    QuickAnswer,
)
from splinescope.computing.jobs import Jobs
from splinescope.computing.messages import (
    CovariancesFound,
    Failed,
    FindCovariances,
    Message,
    Progress,
    SolveMap,
)
from splinescope.computing.packed_result import PackedResult
from splinescope.edits.subject import EditKind
from splinescope.recipe import Recipe
from splinescope.view import Selection


def test_a_proposal_shows_what_it_would_do_and_changes_nothing(desk: Desk) -> None:
    before = desk.shown
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE))
    proposal = desk.editing.proposal
    assert proposal is not None and proposal.preview is not None and proposal.preview.final
    names = dict(proposal.preview.rows)
    assert float(names["predicted change of cost"]) < 0
    assert names["largest move of a pose"].endswith(" mm")
    ghost = desk.session.view.ghost
    assert ghost is not None and ghost.splines is not None and len(ghost.splines)
    assert desk.shown == before
    state = desk.editing.history.state_hash
    desk.do(ask.DropProposal())
    assert desk.session.view.ghost is None
    assert (desk.shown, desk.editing.history.state_hash, desk.journals) == (before, state, [])


def test_solving_again_solves_the_map_with_its_edits(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    run = desk.session.result
    assert run is not None and len(run.edits) == 1
    desk.do(ask.Choose(Recipe(back_end="bs_slam")))
    assert "single beams" in (desk.session.refusal or "")
    recipe = Recipe(back_end="pose_graph")
    desk.do(ask.Choose(recipe), ask.Optimise())
    assert desk.estimator.solved == run.edits
    sent: list[Message] = []
    Jobs(sent.append).do(SolveMap(2, FILE, PackedResult(run.kept, recipe.config(), run.edits)), lambda: False)
    for message in sent:
        desk.session.receive(message)
    solved = desk.session.result
    assert solved is not None and solved.label.endswith("+ 1 by hand") and solved.edits == ()
    assert desk.session.notices[-1].title == "The map is optimised with its one hand edit"
    given = [step.associations for step in solved.snapshot.steps]
    assert given == [step.associations for step in run.snapshot.steps]


def nearly_the_same(near: SplineMap, exact: SplineMap) -> bool:
    """Whether the curves of one map run along those of another, to a centimetre."""
    assert [spline.id for spline in near] == [spline.id for spline in exact]
    for one, other in zip(near, exact, strict=True):
        points = other.sample(0.1)[1]
        if np.linalg.norm(one.curve(one.curve.foot_points(points)) - points, axis=1).max() > 0.01:
            return False
    return True


def map_of(desk: Desk) -> SplineMap:
    assert desk.session.findings.snapshot is not None
    return desk.session.findings.snapshot.map


def test_what_was_looked_at_is_shown_as_soon_as_it_is_accepted(desk: Desk) -> None:
    before = desk.shown
    desk.select()
    desk.do(ask.EditSelected(EditKind.SPLIT), ask.AcceptEdits(), ask.Undo())
    desk.do(ask.Select(Selection("spline", desk.piece().spline or 0)), ask.EditSelected(EditKind.SPLIT))
    desk.session.apply(ask.AcceptEdits())
    assert desk.shown != before, "nobody has answered yet"
    near = map_of(desk)
    desk.editor.answer()
    assert nearly_the_same(near, map_of(desk))


def test_a_quick_answer_is_about_what_is_shown(desk: Desk) -> None:
    for scan in (11, 20):
        desk.do(ask.Select(Selection("spline", desk.piece(scan).spline or 0)), ask.EditSelected(EditKind.SPLIT))
        desk.do(ask.AcceptEdits())
    heard: list[Message] = []
    desk.editor._jobs._send = heard.append
    assert desk.session.result is not None
    desk.do(ask.SwitchEdit(0, False))
    quick = next(message for message in heard if isinstance(message, QuickAnswer))
    last = next(message for message in heard if isinstance(message, EditsMade))
    assert nearly_the_same(quick.ghost.over(desk.session.result.snapshot).map, last.snapshot.map)


def test_the_estimator_measures_what_the_editor_made(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    run = desk.session.result
    assert run is not None and run.amended is not None and desk.estimator.asked_with is run.amended
    heard: list[Message] = []
    jobs = Jobs(heard.append)
    for amended in (run.amended, None):
        jobs.do(FindCovariances(3, FILE, replace(run.packed, amended=amended)), lambda: False)
    handed, made = (message for message in heard if isinstance(message, CovariancesFound))
    assert all(np.array_equal(handed.splines[number], found) for number, found in made.splines.items())
    anew = Jobs(heard.append)
    anew.do(FindCovariances(4, FILE, replace(run.packed, amended=None)), lambda: False)
    alone = next(message for message in heard if isinstance(message, CovariancesFound) and message.job == 4)
    assert all(np.array_equal(handed.splines[number], found) for number, found in alone.splines.items())


def test_a_preview_does_not_wait_for_an_edit_in_the_making(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE))
    desk.session.apply(ask.AcceptEdits())
    desk.look_at_ignoring(20)
    heard: list[Message] = []
    jobs, hear = desk.editor._jobs, desk.editor._jobs._send
    jobs._send = lambda message: (heard.append(message), hear(message))  # type: ignore[assignment]
    make, look = desk.editor.asked
    done: list[bool] = []

    def asked_meanwhile() -> bool:
        if not done:
            done.append(True)
            assert jobs.meanwhile(look, lambda: False) and not jobs.meanwhile(make, lambda: False)
        return False

    jobs.do(make, asked_meanwhile)
    kinds = [type(message) for message in heard]
    assert kinds.index(PreviewFound) < kinds.index(EditsMade)
    first = next(message.preview for message in heard if isinstance(message, PreviewFound))
    assert first.refusal is None and first.ghost is not None


def test_what_was_shown_lately_is_there_at_once(desk: Desk) -> None:
    states = [desk.shown]
    for scan in (11, 20):
        desk.select(scan)
        desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
        states.append(desk.shown)
    told = desk.editing.explanation
    for command, number in ((ask.Undo(), 1), (ask.Undo(), 0), (ask.Redo(), 1), (ask.Redo(), 2)):
        desk.session.apply(command)
        assert desk.shown == states[number] and not desk.editing.making, "nobody has answered"
    assert desk.editing.explanation is told
    assert set(map(type, desk.editor.asked)) == {HandOver}, "for the estimator, who measures them"


def test_several_pieces_are_answered_quickly_too(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[Message] = []
    monkeypatch.setattr(desk.editor._jobs, "_send", lambda message: (heard.append(message), desk.editor.hear(message)))
    desk.do(ask.SelectPieces(pieces(desk)[:2]), ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    assert QuickAnswer in map(type, heard)


def test_the_editor_s_death_is_told_and_what_was_accepted_stays(desk: Desk) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE))
    desk.session.apply(ask.AcceptEdits())
    desk.session.hear(Failed(desk.editor.job, "The estimator ended unexpectedly (signal SIGTERM)."))
    assert [type(request).__name__ for request in desk.editor.asked[-2:]] == ["Prepare", "MakeEdits"]
    desk.editor.answer()
    assert desk.session.result is not None and desk.session.result.edits == desk.editing.history.active != ()


def test_an_edit_in_the_making_tells_how_far_it_is_and_can_be_left_off(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE))
    before, session = desk.shown, desk.session
    session.apply(ask.AcceptEdits())
    job, asked = desk.editing._jobs["make"], desk.editing._now()
    monkeypatch.setattr(desk.editing, "_now", lambda: asked)
    assert session.activity is None or session.activity.work is not Work.EDITING
    monkeypatch.setattr(desk.editing, "_now", lambda: asked + 1.0)
    assert session.activity == Activity(Work.EDITING, job, "Making the edits")
    before_tick = session.revision
    session.tick()
    session.tick()
    assert session.revision == before_tick + 1, "it is shown, once"
    session.hear(Progress(job, "rebuild", 0.4, 3.0))
    assert session.activity == Activity(Work.EDITING, job, "Building the map anew", 0.4, 3.0)
    assert ACTIONS["cancel"].refusal(session) is None
    session.apply(ask.Cancel())
    assert not desk.editing.making and desk.editing.activity is None
    assert desk.editing.history.active == () and desk.editing.history.redo is not None
    desk.editor.answer()
    assert desk.shown == before
    desk.do(ask.Redo())
    assert desk.shown != before and len(desk.editing.history.active) == 1
    desk.editing.stop()
    assert session.notices[-1].title == "Nothing to cancel"


def test_why_no_decision_is_doubted_is_told_truly(desk: Desk) -> None:
    editing = desk.editing
    editing.close()
    assert "finished run" in (editing.no_doubts or "")
    assert "finished run" in (ACTIONS["next-doubt"].refusal(desk.session) or "")
    editing.attend(desk.session.log, desk.session.result)
    assert "are being sought" in (editing.no_doubts or "")
    desk.editor.answer()
    assert editing.doubts.queue or "close enough" in (editing.no_doubts or "")
    desk.select()
    doubt = Doubt(0.7, "one", desk.piece().scan, OnPiece(5, 0, 0, 9))
    editing.doubts = editing.doubts.of((doubt,))
    assert editing.no_doubts is None
    desk.do(ask.StepDoubt(1), ask.SettleDoubt(True))
    assert editing.no_doubts == "No doubtful decision is left."
