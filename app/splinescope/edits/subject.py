"""What is selected, as the subject of an edit: which piece, spline or pose it is, and which edits are possible."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association
from bspline_slam.edits.edit import (
    DropLoop,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    MergeSplines,
    OnPiece,
    PinPose,
    PinSpline,
    SplitSegment,
    SplitSpline,
    in_words,
)
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import MapSpline
from splinescope.pieces import every_piece, name_of_piece, pieces_of, points_of
from splinescope.view import MapView, ScanView, Selection

NEAR = 3.0
"""Splines farther off than this (m) are not offered."""
MOST_TARGETS = 8


class EditKind(Enum):
    """What can be done to what is selected; the value says it on a button."""

    FORCE = "Force to the target"
    FORBID = "Forbid its spline"
    NEW = "Make a new spline of it"
    IGNORE = "Ignore it"
    SPLIT = "Split it"
    MERGE = "Merge with the target"
    PIN = "Pin it where it is"
    DROP_LOOP = "Drop this loop closure"


@dataclass(frozen=True, eq=False, slots=True)
class Subject:
    """The selected thing: a piece of a segment of a key scan with its `pieces` in order, several pieces of a key scan,
    a spline, a pose, or a loop closure. `chosen` are the pieces that an edit is about, be it one or several. `targets`
    are splines that it could be given to or merged with, the likeliest first."""

    segment: ScanSegment | None = None
    pieces: tuple[Association, ...] = ()
    piece: Association | None = None
    chosen: tuple[Association, ...] = ()
    pose: Float[np.ndarray, "3"] | None = None
    scan: int | None = None
    spline: MapSpline | None = None
    closure: tuple[int, int] | None = None
    targets: tuple[int, ...] = ()


NOTHING = Subject()


def subject_of(selection: Selection | None, scan: ScanView | None, world: MapView | None, piece: int) -> Subject:
    """The subject of a selection; piece number `piece` of a segment."""
    if selection is None or world is None:
        return NOTHING
    match selection.kind:
        case "segment" if scan is not None and scan.key:
            return _segment(selection.id, scan, world, piece)
        case "pieces" if scan is not None and scan.key and scan.scan.index == selection.id:
            return _several(selection, scan, world)
        case "spline" | "control point" if selection.id in world.map:
            spline = world.map[selection.id]
            samples = spline.sample(0.2)[1]
            return Subject(spline=spline, targets=tuple(s for s in nearest(world, samples) if s != spline.id))
        case "key pose" if selection.id in world.key_scans:
            return Subject(scan=selection.id, pose=world.key_poses[world.key_scans.index(selection.id)])
        case "closure" if selection.id < len(world.loop_closures):
            closure = world.loop_closures[selection.id]
            return Subject(closure=(closure.earlier, closure.scan)) if closure.accepted else NOTHING
    return NOTHING


def _segment(number: int, scan: ScanView, world: MapView, piece: int) -> Subject:
    segment = next((f.segment for f in scan.segments if f.segment.index == number), None)
    if segment is None:
        return NOTHING
    pieces = pieces_of(segment, scan)
    chosen = pieces[piece % len(pieces)]
    points = points_of(name_of_piece(chosen), scan)
    known = [c.spline for c in chosen.candidates if c.spline in world.map]
    targets = dict.fromkeys(s for s in (*known, *nearest(world, points)) if s != chosen.spline)
    return Subject(
        segment, pieces, chosen, (chosen,), scan.pose, scan.scan.index, targets=tuple(targets)[:MOST_TARGETS]
    )


def _several(selection: Selection, scan: ScanView, world: MapView) -> Subject:
    """The pieces that are still there; any spline near them is a target, but one that all of them have already."""
    chosen = tuple(piece for piece in every_piece(scan) if name_of_piece(piece) in selection.pieces)
    if not chosen:
        return NOTHING
    points = np.concatenate([points_of(name_of_piece(piece), scan) for piece in chosen])
    given = {piece.spline for piece in chosen}
    targets = tuple(spline for spline in nearest(world, points) if given != {spline})
    return Subject(chosen=chosen, pose=scan.pose, scan=scan.scan.index, targets=targets)


def nearest(world: MapView, points: Float[np.ndarray, "m 2"]) -> list[int]:
    """The splines nearest to some points, by their mean distance."""
    low, high = points.min(0) - NEAR, points.max(0) + NEAR
    found = []
    for spline in world.map:
        control = spline.curve.control_points
        if (control.max(0) >= low).all() and (control.min(0) <= high).all():
            t = np.clip(spline.curve.foot_points(points), *spline.span)
            away = float(np.linalg.norm(spline.curve(t) - points, axis=1).mean())
            if away < NEAR:
                found.append((away, spline.id))
    return [spline for _, spline in sorted(found)][:MOST_TARGETS]


def edits_for(
    kind: EditKind, subject: Subject, target: int | None, made: int, point: Float[np.ndarray, "2"] | None = None
) -> tuple[Edit, ...] | str:
    """The edits of a kind on a subject, or why there are none. `made` is the id of a spline that they may make, `point`
    a place that was clicked."""
    piece, spline = subject.piece, subject.spline
    match kind:
        case EditKind.DROP_LOOP if subject.closure is not None:
            return (DropLoop(*subject.closure),)
        case EditKind.PIN if spline is not None:
            return (PinSpline.at(spline.id, spline.curve, spline.span),)
        case EditKind.PIN if subject.pose is not None and subject.scan is not None:
            x, y, heading = subject.pose.tolist()
            return (PinPose(subject.scan, (x, y, heading)),)
        case EditKind.MERGE if spline is not None:
            if target is None:
                return "There is no other spline near it to merge it with."
            return (MergeSplines(min(spline.id, target), max(spline.id, target)),)
        case EditKind.SPLIT if spline is not None:
            x, y = (spline.curve(np.array([np.mean(spline.span)]))[0] if point is None else point).tolist()
            return (SplitSpline(spline.id, (x, y), made),)
        case EditKind.MERGE | EditKind.PIN | EditKind.DROP_LOOP:
            return NEEDS[kind]
        case EditKind.SPLIT if piece is not None and subject.segment is not None:
            return _split(subject, piece, subject.segment, point)
        case EditKind.SPLIT if subject.chosen:
            return "Pieces are split one at a time: select a single one."
        case _ if subject.chosen:
            return _on_pieces(kind, subject.chosen, target, made)
    return NEEDS[kind]


PIECE = "Select a segment of a key scan first."
NEEDS = {
    EditKind.FORCE: PIECE,
    EditKind.FORBID: PIECE,
    EditKind.NEW: PIECE,
    EditKind.IGNORE: PIECE,
    EditKind.SPLIT: "Select a segment of a key scan, or a spline, first.",
    EditKind.MERGE: "Select a spline first.",
    EditKind.PIN: "Select a key pose, a segment of a key scan, or a spline first.",
    EditKind.DROP_LOOP: "Select an accepted loop closure first: they are listed under Quality.",
}


def _on_pieces(
    kind: EditKind, pieces: tuple[Association, ...], target: int | None, made: int
) -> tuple[Edit, ...] | str:
    """The edit of each piece that one of this kind can be made of; each new spline has an id of its own."""
    edits: list[Edit] = []
    refusal = ""
    for piece in pieces:
        found = _on_piece(kind, piece, target, made + len(edits))
        if isinstance(found, str):
            refusal = found
        else:
            edits.append(found)
    return tuple(edits) or refusal


def _on_piece(kind: EditKind, piece: Association, target: int | None, made: int) -> Edit | str:
    where = (piece.scan, piece.segment, piece.first, piece.last)
    match kind:
        case EditKind.FORCE:
            return "There is no other spline near it." if target is None else Force(*where, target)
        case EditKind.FORBID:
            return "It was given to no spline." if piece.spline is None else Forbid(*where, piece.spline)
        case EditKind.NEW:
            return MakeNew(*where, made)
        case _:
            return Ignore(*where)


def _split(
    subject: Subject, piece: Association, segment: ScanSegment, point: Float[np.ndarray, "2"] | None
) -> tuple[Edit, ...] | str:
    inside = (segment.beams > piece.first) & (segment.beams <= piece.last)
    if not inside.any() or subject.pose is None:
        return "A single beam cannot be split."
    points = se2.transform(subject.pose, segment.points[inside])
    beams = segment.beams[inside]
    cut = len(beams) // 2 if point is None else int(np.argmin(np.linalg.norm(points - point, axis=1)))
    return (SplitSegment(piece.scan, piece.segment, int(beams[cut])),)


def name_of(edits: tuple[Edit, ...]) -> str:
    """The name of an action in the history."""
    first = edits[0]
    if len(edits) > 1 and isinstance(first, OnPiece) and len(set(map(_alike, edits))) == 1:
        pieces = f"{len(edits)} pieces of scan {first.scan}"
        match first:
            case Force(spline=spline):
                return f"Force {pieces} to spline {spline}"
            case Forbid():
                return f"Forbid {pieces} their splines"
            case MakeNew():
                return f"Make new splines of {pieces}"
            case _:
                return f"Ignore {pieces}"
    return in_words(first) if len(edits) == 1 else f"{in_words(first)} and {len(edits) - 1} more"


def _alike(edit: Edit) -> tuple[object, ...]:
    """What edits have in common that one name is enough for."""
    scan = edit.scan if isinstance(edit, OnPiece) else None
    return type(edit), scan, edit.spline if isinstance(edit, Force) else None
