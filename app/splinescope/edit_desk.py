"""What commands about hand edits do to a session."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.edits.explain import Worst
from splinescope import commands as ask
from splinescope.browser.values import Bounds
from splinescope.editing import Editing
from splinescope.loop_draft import LoopDraft
from splinescope.marks import marks
from splinescope.notice import Notice
from splinescope.picking import nearest_key_pose, nearest_spline
from splinescope.pieces import name_of_piece, points_of
from splinescope.proposal import Picking
from splinescope.subject import EditKind, Subject, edits_for
from splinescope.view import GhostView, Piece, Selection

if TYPE_CHECKING:
    from splinescope.session import Session

EXAGGERATED = 1.0
"""The largest move of a pose is drawn so long (m) where it is shorter,"""
MOST_EXAGGERATED = 200.0
"""but no more than so many times too long."""


def subject(session: Session) -> Subject:
    """What is selected, as the subject of an edit."""
    return session.subject


def apply(session: Session, command: ask.Command) -> bool:
    """Do what a command says; whether it was one about edits."""
    editing = session.editing
    match command:
        case ask.EditSelected(kind=kind):
            propose(session, kind)
        case ask.ProposeEdits(edits=edits):
            editing.propose(edits)
        case ask.ChooseTarget(by=by, spline=spline):
            _choose(session, by, spline)
        case ask.NextPiece(by=by):
            editing.piece, editing.target = editing.piece + by, 0
        case ask.SelectPieces(pieces=pieces):
            _select_pieces(session, pieces)
        case ask.TogglePiece(piece=piece):
            chosen = tuple(map(name_of_piece, subject(session).chosen))
            _select_pieces(session, tuple(p for p in (*chosen, piece) if p != piece or piece not in chosen))
        case ask.PickNext(what=what):
            _pick_next(session, what)
        case ask.PickPlace(x=x, y=y, near=near):
            _picked(session, np.array([x, y]), near)
        case ask.AcceptEdits():
            editing.accept()
        case ask.DropProposal():
            editing.leave()
        case ask.Undo():
            editing.undo()
        case ask.Redo():
            editing.redo()
        case ask.GoToEdit(cursor=cursor):
            editing.go_to(cursor)
        case ask.SwitchEdit(number=number, on=on):
            editing.switch(number, on)
        case ask.TakeUpEdits(on=on):
            editing.take_up(on)
        case ask.MoveGhost(x=x, y=y, turn=turn):
            if editing.draft is not None:
                editing.move_draft(editing.draft.moved(x, y, turn))
        case ask.MatchGhost():
            editing.match_draft()
        case ask.ShowWorst(number=number):
            _show_worst(session, number)
        case ask.LookThere():
            session.look_wanted = surroundings(session)
        case ask.StepDoubt(by=by):
            editing.doubts = editing.doubts.stepped(by)
            _show_doubt(session)
        case ask.ShowDoubt(number=number):
            editing.doubts = editing.doubts.looking_at(number)
            _show_doubt(session)
        case ask.SettleDoubt(right=right):
            _settle_doubt(session, right)
        case ask.SeekMark(kind=kind, by=by):
            _seek_mark(session, kind, by)
        case _:
            return False
    return True


def target(session: Session) -> int | None:
    """The spline that what is selected would be given to or merged with."""
    targets = subject(session).targets
    return targets[session.editing.target % len(targets)] if targets else None


def refusal(session: Session, kind: EditKind) -> str | None:
    """What stands in the way of an edit of this kind now."""
    wanted = session.editing.refusal or edits_for(kind, subject(session), target(session), session.editing.next_id)
    return wanted if isinstance(wanted, str) else None


def propose(session: Session, kind: EditKind, point: Float[np.ndarray, "2"] | None = None) -> None:
    """Propose an edit of what is selected, or say why not."""
    wanted = edits_for(kind, subject(session), target(session), session.editing.next_id, point)
    if isinstance(wanted, str):
        session.tell(Notice("Nothing was proposed", wanted))
    else:
        session.editing.propose(wanted)


def asks(editing: Editing) -> str:
    """What a person is to do now, over the map: choose something, or decide on what is proposed."""
    if editing.picking is not None:
        return f"{editing.picking.value} Esc cancels."
    proposal = editing.proposal
    if proposal is None:
        return "" if editing.draft is None else "Lay the purple scan where it belongs, then match it (Ctrl + Enter)."
    if proposal.preview is None:
        return f"{proposal.name} …"
    if proposal.preview.refusal is not None:
        return f"{proposal.name}: {proposal.preview.refusal} Esc cancels."
    return f"Enter accepts, Esc cancels: {proposal.name}."


def _select_pieces(session: Session, pieces: tuple[Piece, ...]) -> None:
    """Select pieces of the scan shown; a single one as a segment that it belongs to."""
    scan = session.scan_view
    if scan is None or not scan.key:
        session.tell(Notice("Nothing was selected", "Only pieces of key scans can be: Alt + K leads to the next one."))
    elif not pieces:
        session.apply(ask.Select(None))
    elif len(pieces) == 1:
        session.apply(ask.Select(Selection("segment", pieces[0][0])))
        _look_at_piece(session, pieces[0])
    else:
        session.apply(ask.Select(Selection("pieces", scan.scan.index, pieces=tuple(sorted(set(pieces))))))


def _look_at_piece(session: Session, piece: Piece) -> None:
    names = list(map(name_of_piece, subject(session).pieces))
    session.editing.piece = names.index(piece) if piece in names else 0


def _choose(session: Session, by: int, spline: int | None) -> None:
    """Another target; what was proposed for the old one is proposed for the new one."""
    editing, targets = session.editing, subject(session).targets
    if spline is not None and spline not in targets:
        session.tell(Notice("Nothing was chosen", f"Spline {spline} is too far from what is selected."))
        return
    editing.target = targets.index(spline) if spline is not None else editing.target + by
    if editing.proposal is not None or spline is not None:
        propose(session, EditKind.MERGE if subject(session).spline is not None else EditKind.FORCE)


def _pick_next(session: Session, what: Picking | None) -> None:
    editing = session.editing
    if editing.refusal is not None:
        session.tell(Notice("Nothing can be chosen", editing.refusal))
    else:
        editing.picking = None if editing.picking is what else what


def _picked(session: Session, point: Float[np.ndarray, "2"], near: float) -> None:
    editing, what = session.editing, session.editing.picking
    if what is None and editing.draft is not None:
        editing.move_draft(editing.draft.marked(float(point[0]), float(point[1])))
        return
    if what is Picking.PLACE:
        propose(session, EditKind.SPLIT, point)
    elif what is Picking.TARGET:
        spline = nearest_spline(session.view, point, near)
        if spline is None:
            session.tell(Notice("Nothing was chosen", "There is no spline where you clicked."))
        else:
            _choose(session, 0, spline)
    elif what is Picking.LOOP:
        other, scan = nearest_key_pose(session.view, point), subject(session).scan
        if other is not None and scan is not None and other != scan:
            begin_loop(session, min(scan, other), max(scan, other))
    editing.picking = None


def begin_loop(session: Session, earlier: int, scan: int) -> None:
    """Lay one key scan over another where the estimate has them."""
    world, step = session.map_view, session.findings.steps.get(scan)
    if world is None or step is None:
        return
    poses = dict(zip(world.key_scans, world.key_poses, strict=False))
    points = np.concatenate([np.zeros((0, 2)), *(segment.points for segment in step.segments)])
    guess = se2.between(poses[earlier], poses[scan])
    session.editing.begin_draft(LoopDraft(earlier, scan, poses[earlier], guess, points))


def _show_worst(session: Session, number: int) -> None:
    """Go to one of the worst residuals."""
    explanation = session.editing.explanation
    if explanation is None or not 0 <= number < len(explanation.worst):
        return
    worst = explanation.worst[number]
    session.apply(ask.Seek(worst.scan))
    session.apply(ask.Select(_selection_of(session, worst)))
    session.apply(ask.LookThere())


def _show_doubt(session: Session) -> None:
    """Go to the doubtful decision looked at."""
    doubt = session.editing.doubts.current
    if doubt is None:
        session.tell(Notice("Nothing to look at", session.editing.no_doubts or ""))
        return
    session.editing.leave()
    session.apply(ask.Seek(doubt.scan))
    if doubt.closure is not None:
        session.apply(ask.Select(Selection("closure", doubt.closure)))
    elif doubt.piece is not None:
        session.apply(ask.Select(Selection("segment", doubt.piece.segment)))
        _look_at_piece(session, (doubt.piece.segment, doubt.piece.first, doubt.piece.last))
    session.apply(ask.LookThere())


AROUND = 1.0
"""So much (m) of what lies around a thing is shown with it."""


def surroundings(session: Session) -> Bounds | None:
    """The rectangle around what is selected, or else around the robot; None where nothing is shown."""
    scan, found, chosen, world = session.scan_view, session.subject, session.selection, session.map_view
    if scan is None or world is None:
        return None
    points = [scan.pose[None, :2]]
    if found.chosen:
        points = [points_of(name_of_piece(piece), scan) for piece in found.chosen]
    elif found.spline is not None:
        points = [found.spline.sample(0.2)[1]]
    elif chosen is not None and chosen.kind == "closure" and chosen.id < len(world.loop_closures):
        closure, poses = world.loop_closures[chosen.id], dict(zip(world.key_scans, world.key_poses, strict=False))
        points = [poses[end][None, :2] for end in (closure.earlier, closure.scan) if end in poses]
    elif found.pose is not None:
        points = [found.pose[None, :2]]
    together = np.concatenate(points)
    (left, low), (right, high) = together.min(axis=0) - AROUND, together.max(axis=0) + AROUND
    return float(left), float(low), float(right), float(high)


def _settle_doubt(session: Session, right: bool) -> None:
    """Find the decision looked at right, or propose to overrule it."""
    editing, doubt = session.editing, session.editing.doubts.current
    if doubt is None:
        session.tell(Notice("Nothing is doubted", "Go to a doubtful decision first."))
    elif right:
        editing.doubts = editing.doubts.settled()
        if editing.doubts.current is not None:
            _show_doubt(session)
    elif doubt.overrule:
        editing.propose(doubt.overrule)
    else:
        session.tell(Notice("Nothing was proposed", "To close this loop after all, lay one scan over the other."))


def _seek_mark(session: Session, kind: str, by: int) -> None:
    """Go to the next mark of a kind on the timeline."""
    places = np.unique([mark.position for mark in marks(session.findings) if mark.kind == kind])
    ahead = places[places > session.cursor] if by > 0 else places[places < session.cursor][::-1]
    if len(ahead):
        session.apply(ask.Seek(int(ahead[0])))
    else:
        session.tell(Notice("No such mark", f"There is none {'later' if by > 0 else 'earlier'} on the timeline."))


def _selection_of(session: Session, worst: Worst) -> Selection:
    if worst.segment is not None:
        return Selection("segment", worst.segment)
    closures = session.map_view.loop_closures if session.map_view is not None else ()
    pair = (worst.other, worst.scan)
    found = (k for k, closure in enumerate(closures) if (closure.earlier, closure.scan) == pair and closure.accepted)
    number = next(found, None)
    return Selection("key pose", worst.scan) if number is None else Selection("closure", number)


def ghost_view(session: Session) -> GhostView | None:
    """What is drawn of a proposal, of a drafted loop closure, and of what the last edits moved."""
    editing = session.editing
    preview = editing.proposal.preview if editing.proposal is not None else None
    ghost = preview.ghost if preview is not None else None
    moves = None if editing.proposal is not None or editing.explanation is None else _moves(session)
    if ghost is None and editing.draft is None and moves is None:
        return None
    return GhostView(
        splines=ghost.splines if ghost is not None else None,
        path=ghost.poses if ghost is not None else None,
        points=editing.draft.ghost if editing.draft is not None else None,
        marks=editing.draft.marks if editing.draft is not None else (),
        moves=moves,
    )


def _moves(session: Session) -> Float[np.ndarray, "n 2 2"] | None:
    """Lines from where key poses were to where edits moved them, drawn longer where they are short."""
    base, snapshot = session.editing.base, session.findings.snapshot
    if base is None or snapshot is None or len(base.snapshot.poses) != len(snapshot.poses):
        return None
    keys = snapshot.key_scans
    before, after = base.snapshot.poses[keys, :2], snapshot.poses[keys, :2]
    largest = float(np.linalg.norm(after - before, axis=1).max(initial=0.0))
    if largest < 1e-4:
        return None
    longer = min(max(EXAGGERATED / largest, 1.0), MOST_EXAGGERATED)
    return np.stack([after, after + longer * (after - before)], axis=1)
