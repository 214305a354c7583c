"""Does what is asked for by hand: turns what is selected, clicked or doubted into edits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.edits.explain import Worst
from splinescope import commands as ask
from splinescope.edits.loop_draft import LoopDraft
from splinescope.edits.proposal import Picking
from splinescope.edits.subject import EditKind
from splinescope.notice import Notice
from splinescope.picking import nearest_key_pose, nearest_spline
from splinescope.pieces import name_of_piece
from splinescope.shown import Shown
from splinescope.view import MapView, Piece, Selection


class EditDesk:
    """Does commands about edits of what is `shown`; to look at other things or other moments it gives commands to
    `do`."""

    def __init__(self, shown: Shown, do: Callable[[ask.Command], None]) -> None:
        self._shown, self._do, self._editing = shown, do, shown.editing

    def apply(self, command: ask.EditCommand) -> None:
        """Do what a command says."""
        editing = self._editing
        match command:
            case ask.EditSelected(kind=kind):
                self._propose(kind)
            case ask.ProposeEdits(edits=edits):
                editing.propose(edits)
            case ask.ChooseTarget(by=by, spline=spline):
                self._choose(by, spline)
            case ask.NextPiece(by=by):
                self._shown.piece, self._shown.choice = self._shown.piece + by, 0
            case ask.SelectPieces(pieces=pieces):
                self._select_pieces(pieces)
            case ask.TogglePiece(piece=piece):
                chosen = tuple(map(name_of_piece, self._shown.subject.chosen))
                self._select_pieces(tuple(p for p in (*chosen, piece) if p != piece or piece not in chosen))
            case ask.PickNext(what=what):
                self._pick_next(what)
            case ask.PickPlace(x=x, y=y, near=near):
                self._picked(np.array([x, y]), near)
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
                self._show_worst(number)
            case ask.StepDoubt(by=by):
                editing.doubts = editing.doubts.stepped(by)
                self._show_doubt()
            case ask.ShowDoubt(number=number):
                editing.doubts = editing.doubts.looking_at(number)
                self._show_doubt()
            case ask.SettleDoubt(right=right):
                self._settle_doubt(right)

    # -- what is edited ------------------------------------------------------------------------------------------
    def _propose(self, kind: EditKind, point: Float[np.ndarray, "2"] | None = None) -> None:
        """Propose an edit of what is selected, or say why not."""
        wanted = self._shown.edits(kind, point)
        if isinstance(wanted, str):
            self._tell("Nothing was proposed", wanted)
        else:
            self._editing.propose(wanted)

    def _select_pieces(self, pieces: tuple[Piece, ...]) -> None:
        """Select pieces of the scan shown; a single one as a segment that it belongs to."""
        scan = self._shown.scan_view
        if scan is None or not scan.key:
            self._tell("Nothing was selected", "Only pieces of key scans can be: Alt + K leads to the next one.")
        elif not pieces:
            self._do(ask.Select(None))
        elif len(pieces) == 1:
            self._select_piece(pieces[0])
        else:
            self._do(ask.Select(Selection("pieces", scan.scan.index, pieces=tuple(sorted(set(pieces))))))

    def _select_piece(self, piece: Piece) -> None:
        """Select a segment, and look at one of its pieces."""
        self._do(ask.Select(Selection("segment", piece[0])))
        names = list(map(name_of_piece, self._shown.subject.pieces))
        self._shown.piece = names.index(piece) if piece in names else 0

    def _choose(self, by: int, spline: int | None) -> None:
        """Another target; what was proposed for the old one is proposed for the new one."""
        shown, subject = self._shown, self._shown.subject
        if spline is not None and spline not in subject.targets:
            self._tell("Nothing was chosen", f"Spline {spline} is too far from what is selected.")
            return
        shown.choice = subject.targets.index(spline) if spline is not None else shown.choice + by
        if self._editing.proposal is not None or spline is not None:
            self._propose(EditKind.MERGE if subject.spline is not None else EditKind.FORCE)

    # -- clicks --------------------------------------------------------------------------------------------------
    def _pick_next(self, what: Picking | None) -> None:
        editing = self._editing
        if editing.refusal is not None:
            self._tell("Nothing can be chosen", editing.refusal)
        else:
            editing.picking = None if editing.picking is what else what

    def _picked(self, point: Float[np.ndarray, "2"], near: float) -> None:
        editing, shown, what = self._editing, self._shown, self._editing.picking
        if what is None and editing.draft is not None:
            editing.move_draft(editing.draft.marked(float(point[0]), float(point[1])))
            return
        if what is Picking.PLACE:
            self._propose(EditKind.SPLIT, point)
        elif what is Picking.TARGET:
            spline = nearest_spline(shown.view, point, near)
            if spline is None:
                self._tell("Nothing was chosen", "There is no spline where you clicked.")
            else:
                self._choose(0, spline)
        elif what is Picking.LOOP:
            other, scan = nearest_key_pose(shown.view, point), shown.subject.scan
            if other is not None and scan is not None and other != scan:
                self._begin_loop(min(scan, other), max(scan, other))
        editing.picking = None

    def _begin_loop(self, earlier: int, scan: int) -> None:
        """Lay one key scan over another where the estimate has them."""
        world, step = self._shown.map_view, self._shown.findings.steps.get(scan)
        if world is None or step is None:
            return
        poses = dict(zip(world.key_scans, world.key_poses, strict=False))
        points = np.concatenate([np.zeros((0, 2)), *(segment.points for segment in step.segments)])
        guess = se2.between(poses[earlier], poses[scan])
        self._editing.begin_draft(LoopDraft(earlier, scan, poses[earlier], guess, points))

    # -- what to look at -----------------------------------------------------------------------------------------
    def _show_worst(self, number: int) -> None:
        """Go to one of the worst residuals."""
        explanation = self._editing.explanation
        if explanation is None or not 0 <= number < len(explanation.worst):
            return
        worst = explanation.worst[number]
        self._do(ask.Seek(worst.scan))
        self._do(ask.Select(selection_of(worst, self._shown.map_view)))
        self._do(ask.LookThere())

    def _show_doubt(self) -> None:
        """Go to the doubtful decision looked at."""
        doubt = self._editing.doubts.current
        if doubt is None:
            self._tell("Nothing to look at", self._editing.no_doubts or "")
            return
        self._editing.leave()
        self._do(ask.Seek(doubt.scan))
        if doubt.closure is not None:
            self._do(ask.Select(Selection("closure", doubt.closure)))
        elif doubt.piece is not None:
            self._select_piece((doubt.piece.segment, doubt.piece.first, doubt.piece.last))
        self._do(ask.LookThere())

    def _settle_doubt(self, right: bool) -> None:
        """Find the decision looked at right, or propose to overrule it."""
        editing, doubt = self._editing, self._editing.doubts.current
        if doubt is None:
            self._tell("Nothing is doubted", "Go to a doubtful decision first.")
        elif right:
            editing.doubts = editing.doubts.settled()
            if editing.doubts.current is not None:
                self._show_doubt()
        elif doubt.overrule:
            editing.propose(doubt.overrule)
        else:
            self._tell("Nothing was proposed", "To close this loop after all, lay one scan over the other.")

    def _tell(self, title: str, sentence: str) -> None:
        self._shown.tell(Notice(title, sentence))


def selection_of(worst: Worst, world: MapView | None) -> Selection:
    """The thing in the page that a residual belongs to."""
    if worst.segment is not None:
        return Selection("segment", worst.segment)
    closures = world.loop_closures if world is not None else ()
    pair = (worst.other, worst.scan)
    found = (k for k, closure in enumerate(closures) if (closure.earlier, closure.scan) == pair and closure.accepted)
    number = next(found, None)
    return Selection("key pose", worst.scan) if number is None else Selection("closure", number)
