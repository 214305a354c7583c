"""Edits of pieces: which spline beams of one segment are given to, by hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association, Verdict
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import Forbid, Force, Ignore, MakeNew, OnPiece, SplitSegment
from bspline_slam.edits.spline_edits import lengthened_through
from bspline_slam.errors import EditError, GeometryError
from bspline_slam.fitting import cumulated_chords
from bspline_slam.models.protocol import Model
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.spline_map import MapSpline, SplineMap

LEAST_BEAMS = 2
"""Fewer beams make no curve."""


def force(decisions: Decisions, edit: Force, model: Model) -> Decisions:
    """The piece given to the spline, which is lengthened where the piece reaches beyond its end."""
    spline, points = decisions.spline(edit.spline), decisions.points(edit)
    longer = lengthened_through(spline, points, model)
    if longer is not spline:
        history = (*spline.history, f"lengthened by hand to {longer.length:.2f} m, with scan {edit.scan}")
        decisions = decisions.with_spline(replace(longer, history=history))
    return _given(decisions, edit, Verdict.MATCHED, edit.spline, rms_across(longer, points))


def forbid(decisions: Decisions, edit: Forbid) -> Decisions:
    """What of the piece was given to the spline goes to the best other candidate within the gate, or to none."""
    number = decisions.number(edit.scan)
    out = []
    for association in decisions.keys[number].associations:
        if association.spline != edit.spline or not _overlap(association, edit):
            out.append(association)
            continue
        others = tuple(c for c in association.candidates if c.spline != edit.spline)
        second = next((c for c in others if c.distance <= association.gate and c.spline in decisions.splines), None)
        taken = replace(association, candidates=others, relation=None)
        if second is None:
            out.append(replace(taken, verdict=Verdict.IGNORED, spline=None, distance=float("nan"), by="hand"))
        else:
            out.append(replace(taken, verdict=Verdict.MATCHED, spline=second.spline, distance=second.distance))
    return decisions.with_associations(number, tuple(out))


def make_new(decisions: Decisions, edit: MakeNew, model: Model) -> Decisions:
    """A spline through the piece. Raises EditError where so few beams make none."""
    if edit.spline in decisions.splines:
        raise EditError(f"there is a spline {edit.spline} already")
    points = decisions.points(edit)
    length = float(cumulated_chords(points)[-1])
    try:
        if len(points) < LEAST_BEAMS:
            raise GeometryError(f"it has {len(points)} beam")
        curve = model.through(points)
    except GeometryError as error:
        raise EditError(f"no curve goes through this piece: {error}") from None
    history = (f"made by hand of scan {edit.scan}, {length:.2f} m",)
    made = MapSpline(edit.spline, curve, (0.0, length), edit.scan, 1, history)
    return _given(decisions.with_spline(made), edit, Verdict.NEW, edit.spline, float("nan"))


def ignore(decisions: Decisions, edit: Ignore) -> Decisions:
    """The piece given to no spline."""
    decisions.points(edit)
    return _given(decisions, edit, Verdict.IGNORED, None, float("nan"))


def split_segment(decisions: Decisions, edit: SplitSegment) -> Decisions:
    """The piece with this beam cut before it. Raises EditError where no piece holds it and the beam before it."""
    number, segment = decisions.number(edit.scan), decisions.segment(edit.scan, edit.segment)
    before, after = segment.beams[segment.beams < edit.beam], segment.beams[segment.beams >= edit.beam]
    associations = decisions.keys[number].associations
    for k, association in enumerate(associations):
        if association.segment == edit.segment and association.first < edit.beam <= association.last and len(before):
            parts = (replace(association, last=int(before[-1])), replace(association, first=int(after[0])))
            return decisions.with_associations(number, (*associations[:k], *parts, *associations[k + 1 :]))
    raise EditError(f"no piece of segment {edit.segment} of scan {edit.scan} can be split before beam {edit.beam}")


def rms_across(spline: MapSpline, points: Float[np.ndarray, "m 2"]) -> float:
    """RMS distance of world points across a spline (m)."""
    return float(np.sqrt(np.mean(np.square(across(spline, points)))))


def across(spline: MapSpline, points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
    """Signed distances of world points across a spline (m)."""
    t = spline.curve.foot_points(points)
    return ((points - spline.curve(t)) * spline.curve.normals(t)).sum(1)


def facing(decisions: Decisions, edit: Force | MakeNew) -> Float[np.ndarray, "m"]:
    """Signed distances (m) across the spline of those beams of a piece that count when they are given to it: they face
    it, and end no farther beside it than they may. Raises EditError where the spline is gone."""
    number = decisions.number(edit.scan)
    given = Association(
        edit.scan, edit.segment, edit.first, edit.last, Verdict.MATCHED, edit.spline, float("nan"), float("nan")
    )
    splines = SplineMap((decisions.spline(edit.spline),))
    sights = collect_sights([replace(decisions.keys[number], associations=(given,))], splines)
    feet = find_feet(sights, splines, decisions.poses[number : number + 1], np.inf)
    return feet.across[feet.counts]


def _given(decisions: Decisions, piece: OnPiece, verdict: Verdict, spline: int | None, distance: float) -> Decisions:
    """The piece given to a spline by hand; what other pieces have of its beams they lose."""
    number, segment = decisions.number(piece.scan), decisions.segment(piece.scan, piece.segment)
    old = decisions.keys[number].associations
    mine = [association for association in old if _overlap(association, piece)]
    inside = segment.beams[(segment.beams >= piece.first) & (segment.beams <= piece.last)]
    first, last = int(inside[0]), int(inside[-1])
    gate = mine[0].gate if mine else float("nan")
    candidates = max(mine, key=lambda a: a.last - a.first).candidates if mine else ()
    made = Association(
        piece.scan, piece.segment, first, last, verdict, spline, distance, gate, candidates, None, "hand"
    )
    rest = [part for association in old for part in _rest(association, piece, segment.beams.tolist())]
    return decisions.with_associations(number, (*rest, made))


def _overlap(association: Association, piece: OnPiece) -> bool:
    return association.segment == piece.segment and association.first <= piece.last and piece.first <= association.last


def _rest(association: Association, piece: OnPiece, beams: list[int]) -> Iterator[Association]:
    """What a piece leaves of an association: the beams before it and those after it."""
    if not _overlap(association, piece):
        yield association
        return
    before = [beam for beam in beams if association.first <= beam < piece.first]
    after = [beam for beam in beams if piece.last < beam <= association.last]
    if before:
        yield replace(association, last=before[-1])
    if after:
        yield replace(association, first=after[0])
