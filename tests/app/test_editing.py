"""Hand edits in a session: proposed, accepted, undone, kept; with the real editor's work, done at once."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from app.logs import file_of
from bspline_slam.association import Association
from bspline_slam.edits.doubts import Doubt
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    CloseLoop,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    OnPiece,
    PinPose,
)
from bspline_slam.edits.history import History
from bspline_slam.edits.journal import read_journal
from bspline_slam.logs import open_log
from bspline_slam.measuring import Picked
from bspline_slam.slam import SlamConfig, Snapshot
from bspline_slam.spline_map import SplineMap
from splinescope import commands as ask
from splinescope.actions import ACTIONS
from splinescope.activity import Activity, Work
from splinescope.browser.preferences import Preferences
from splinescope.computing.edit_jobs import Jobs as EditJobs
from splinescope.computing.edit_messages import (
    EditRequest,
    EditsMade,
    FindPreview,
    HandOver,
    MakeEdits,
    MatchLoop,
    Prepare,
    Preview,
    PreviewFound,
    QuickAnswer,
)
from splinescope.computing.jobs import Jobs
from splinescope.computing.messages import (
    CovariancesFound,
    Failed,
    FindCovariances,
    Finished,
    LogFile,
    Message,
    ProcessLog,
    Progress,
    SolveMap,
)
from splinescope.computing.packed_result import PackedResult
from splinescope.editing import Editing
from splinescope.journals import Journals
from splinescope.loop_draft import LoopDraft
from splinescope.marks import marks
from splinescope.panels.inspector import shown
from splinescope.pieces import every_piece, name_of_piece
from splinescope.proposal import Picking
from splinescope.recipe import Recipe
from splinescope.session import Session
from splinescope.subject import EditKind
from splinescope.view import Piece, Selection

LOG = Path(__file__).parents[2] / "sample_logs" / "three_splines.log.gz"
FILE = file_of(open_log(LOG))


class AtOnce:
    """An estimator and an editor that do their work in this process, as soon as they are asked."""

    def __init__(self, hear: Callable[[Message], None]) -> None:
        self.job = 0
        self.asked: list[EditRequest] = []
        self.hear = hear
        self._jobs = EditJobs(hear)

    def _ask(self, request: EditRequest) -> int:
        self.job = request.job
        self.asked.append(request)
        return request.job

    def answer(self) -> None:
        """Do what was asked for."""
        while self.asked:
            self._jobs.do(self.asked.pop(0), lambda: False)

    def prepare(self, kept: bytes, config: SlamConfig) -> int:
        return self._ask(Prepare(self.job + 1, kept, config))

    def preview(self, in_force: tuple[Edit, ...], proposed: tuple[Edit, ...]) -> int:
        return self._ask(FindPreview(self.job + 1, in_force, proposed))

    def make(self, edits: tuple[Edit, ...], shown: tuple[Edit, ...]) -> int:
        return self._ask(MakeEdits(self.job + 1, edits, shown))

    def match(self, in_force: tuple[Edit, ...], earlier: int, scan: int, guess: np.ndarray) -> int:
        return self._ask(MatchLoop(self.job + 1, in_force, earlier, scan, guess))

    def hand_over(self, edits: tuple[Edit, ...]) -> int:
        return self._ask(HandOver(self.job + 1, edits))

    def cancel(self) -> None:
        """Nothing runs."""


class Idle:
    """An estimator that never answers: its messages are made by the test."""

    def process(self, log: LogFile, config: SlamConfig) -> int:
        return 1

    def solve(self, log: LogFile, result: PackedResult) -> int:
        self.solved = result.edits
        return 2

    def covariances(self, log: LogFile, result: PackedResult) -> int:
        self.asked_with = result.amended
        return 3

    def measure(self, result: PackedResult, first: Picked, second: Picked) -> int:
        return 4

    def cancel(self) -> None:
        """Nothing runs."""


@pytest.fixture(scope="module")
def finished() -> list[Message]:
    """What the estimator says of the sample log."""
    sent: list[Message] = []
    Jobs(sent.append).do(ProcessLog(1, FILE, SlamConfig()), lambda: False)
    assert isinstance(sent[-1], Finished)
    return sent


class Desk:
    """A session with a finished run, and an editor that works when told."""

    def __init__(self, folder: Path, finished: list[Message], offered: bool = False, log: Path = LOG) -> None:
        self.folder = folder
        self.editor = AtOnce(lambda message: self.session.hear(message))
        journals = Journals(folder, offered=offered)
        self.estimator = Idle()
        self.session = Session(
            self.estimator,
            lambda _: None,
            Preferences(),
            editor=self.editor,
            journals=journals,  # type: ignore[arg-type]
        )
        request = ask.OpenLog(log)
        self.session.apply(request)
        self.session.apply(ask.LogOpened(request, open_log(log)))
        for message in finished:
            self.session.receive(message)
        self.editor.answer()

    @property
    def editing(self) -> Editing:
        return self.session.editing

    @property
    def journal(self) -> Path:
        (path,) = self.journals
        return path

    @property
    def journals(self) -> list[Path]:
        return sorted(self.folder.glob("*.edits"))

    def do(self, *commands: ask.Command) -> None:
        for command in commands:
            self.session.apply(command)
            self.editor.answer()

    @property
    def shown(self) -> str:
        """A hash of all that is shown of the result."""
        snapshot, digest = self.session.findings.snapshot, hashlib.sha256()
        assert snapshot is not None
        digest.update(snapshot.poses.tobytes())
        for spline in snapshot.map:
            digest.update(f"{spline.id} {spline.span} {spline.observations}".encode())
            digest.update(spline.curve.control_points.tobytes())
        for scan, step in sorted(self.session.findings.steps.items()):
            told = [(a.segment, a.first, a.last, a.spline, a.by) for a in step.associations]
            digest.update(f"{scan} {told}".encode())
        return digest.hexdigest()

    def piece(self, scan: int = 11) -> Association:
        step = self.session.findings.steps[scan]
        return max((a for a in step.associations if a.spline is not None), key=lambda a: a.last - a.first)

    def select(self, scan: int = 11) -> None:
        piece = self.piece(scan)
        self.do(ask.Seek(scan), ask.Select(Selection("segment", piece.segment)))

    def look_at_ignoring(self, scan: int) -> None:
        """Propose to ignore the longest piece of a scan, while the editor has not answered yet."""
        piece = self.piece(scan)
        for command in (ask.Seek(scan), ask.Select(Selection("segment", piece.segment))):
            self.session.apply(command)
        self.session.apply(ask.EditSelected(EditKind.IGNORE))


@pytest.fixture
def desk(tmp_path: Path, finished: list[Message]) -> Desk:
    return Desk(tmp_path, finished)


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


def pieces(desk: Desk, scan: int = 11) -> tuple[Piece, ...]:
    desk.do(ask.Seek(scan))
    shown = desk.session.scan_view
    assert shown is not None
    return tuple(map(name_of_piece, every_piece(shown)))


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


def test_two_pairs_of_points_lay_a_scan_where_they_say() -> None:
    draft = LoopDraft(0, 5, np.zeros(3), np.array([1.0, 2.0, 0.5]), np.array([[1.0, 0.0], [0.0, 2.0]]))
    wanted = replace(draft, guess=np.array([-0.5, 0.3, 1.2]))
    for a, b in zip(draft.ghost, wanted.ghost, strict=True):
        draft = draft.marked(*a.tolist()).marked(*b.tolist())
    np.testing.assert_allclose(draft.guess, wanted.guess, atol=1e-9)
    assert draft.marks == ()


def test_reopening_gives_every_accepted_edit(desk: Desk, tmp_path: Path, finished: list[Message]) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    desk.select(12)
    desk.do(ask.EditSelected(EditKind.SPLIT), ask.AcceptEdits(), ask.EditSelected(EditKind.PIN))
    shown, history = desk.shown, desk.editing.history
    desk.editing.close()
    again = Desk(tmp_path, finished)
    assert (again.shown, again.editing.history) == (shown, history)


def test_edits_from_before_are_offered_and_can_be_set_aside(tmp_path: Path, finished: list[Message]) -> None:
    first = Desk(tmp_path, finished, offered=True)
    first.select()
    first.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    shown = first.shown
    first.editing.close()
    again = Desk(tmp_path, finished, offered=True)
    assert again.editing.offer is not None and again.editing.history == History()
    again.do(ask.EditSelected(EditKind.IGNORE))
    assert again.editing.proposal is None
    again.do(ask.TakeUpEdits(True))
    assert again.shown == shown
    again.editing.close()
    anew = Desk(tmp_path, finished, offered=True)
    anew.do(ask.TakeUpEdits(False))
    assert anew.editing.history == History() and anew.editing.refusal is None
    assert len(anew.journals) == 1
    anew.select()
    anew.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    assert len(anew.journals) == 2


def test_a_damaged_journal_is_told_and_not_touched(desk: Desk, tmp_path: Path, finished: list[Message]) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits(), ask.Undo())
    desk.editing.close()
    lines = desk.journal.read_bytes().replace(b"Ignore", b"Ignone", 1)
    desk.journal.write_bytes(lines)
    again = Desk(tmp_path, finished)
    assert any("damaged" in trouble for trouble in again.session.troubles)
    assert again.journal.read_bytes() == lines


def test_edits_go_with_a_log_that_moved(desk: Desk, tmp_path: Path, finished: list[Message]) -> None:
    desk.select()
    desk.do(ask.EditSelected(EditKind.IGNORE), ask.AcceptEdits())
    history = desk.editing.history
    desk.editing.close()
    moved = tmp_path / "elsewhere.log.gz"
    moved.write_bytes(LOG.read_bytes())
    assert Desk(tmp_path, finished, log=moved).editing.history == history


def test_a_session_says_when_its_log_moved_or_changed(tmp_path: Path) -> None:
    log = open_log(LOG)
    here = str(LOG.absolute())
    for known, title in (
        (Preferences(log="/old/place.log", log_hash=log.content_hash), "The log has moved"),
        (Preferences(log=here, log_hash="another"), "The log has changed"),
        (Preferences(log=here, log_hash=log.content_hash), None),
        (Preferences(), None),
    ):
        session, request = Session(Idle(), lambda _: None, known), ask.OpenLog(LOG)
        session.apply(request)
        session.apply(ask.LogOpened(request, log))
        assert [notice.title for notice in session.notices] == ([title] if title else [])
        assert (session.preferences.log, session.preferences.log_hash) == (here, log.content_hash)


def test_what_cannot_be_done_says_why(desk: Desk) -> None:
    desk.do(ask.EditSelected(EditKind.FORCE), ask.Undo(), ask.Redo(), ask.AcceptEdits(), ask.SwitchEdit(3))
    told = {notice.title for notice in desk.session.notices}
    assert {"Nothing was proposed", "Nothing to undo", "Nothing to redo", "Nothing to accept"} <= told
    assert desk.journals == []
    for kind in EditKind:
        assert desk.session.edit_refusal(kind)


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


# -- random operations ---------------------------------------------------------------------------------------------
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
    tmp_path: Path, finished: list[Message]
) -> None:
    desk = Desk(tmp_path, finished)
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

    finished: list[Message]
    folders: Iterator[Path]

    def __init__(self) -> None:
        super().__init__()
        self.desk = Desk(next(self.folders), self.finished)
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
        self.desk = Desk(folder, self.finished)
        assert (self.desk.editing.history, self.desk.shown) == (history, shown)

    @invariant()
    def the_same_edits_show_the_same(self) -> None:
        assert not self.desk.editing.making
        found = self.seen.setdefault(self.desk.editing.history.state_hash, self.desk.shown)
        assert self.desk.shown == found

    def teardown(self) -> None:
        self.desk.editing.close()


def test_a_session_under_random_operations(tmp_path_factory: pytest.TempPathFactory, finished: list[Message]) -> None:
    from hypothesis.stateful import run_state_machine_as_test

    Operating.finished = finished
    Operating.folders = (tmp_path_factory.mktemp("edits") for _ in itertools.count())
    run_state_machine_as_test(Operating, settings=settings(max_examples=6, stateful_step_count=10, deadline=None))


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
