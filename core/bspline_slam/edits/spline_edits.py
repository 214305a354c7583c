"""Edits of splines: split in two, merged into one, pinned; and curves made longer through what they are given."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.association import Association
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import MergeSplines, PinSpline, SplitSpline
from bspline_slam.errors import EditError
from bspline_slam.fitting import cumulated_chords
from bspline_slam.models.protocol import Model
from bspline_slam.sights import collect_sights
from bspline_slam.spline_map import MapSpline, SplineMap

SAMPLING = 0.05
"""Distance (m) between the points of a curve that is drawn anew."""
BEYOND = 0.05
"""What lies farther beyond an end than this (m) makes a curve longer."""
WIDEST_GAP = 1.0
"""No curve is drawn over a longer gap (m)."""
ROUNDING = 1e-6
SHORTEST = 0.1
"""No part of a split spline is shorter (m)."""


def split_spline(decisions: Decisions, edit: SplitSpline, model: Model) -> Decisions:
    """The spline up to the point, and a new one from there on, each with the beams that saw it."""
    spline = decisions.spline(edit.spline)
    if edit.new in decisions.splines:
        raise EditError(f"there is a spline {edit.new} already")
    low, high = spline.span
    t = float(spline.curve.foot_points(np.array([edit.point]))[0])
    if min(spline.curve.length((low, t)), spline.curve.length((t, high))) < SHORTEST if low < t < high else True:
        raise EditError(f"spline {spline.id} cannot be split so near to its end")
    decisions = decisions.with_spline(_part(spline, spline.id, (low, t), model))
    decisions = decisions.with_spline(_part(spline, edit.new, (t, high), model))
    seen = collect_sights(decisions.keys, SplineMap((spline,)))
    beyond = spline.curve.foot_points(se2.transform(decisions.poses[seen.pose], seen.points)) > t
    cuts = np.searchsorted(seen.piece, np.arange(seen.piece.max(initial=-1) + 2)).tolist()
    pieces = ((seen.beam[a:b], beyond[a:b]) for a, b in pairwise(cuts))
    for number in np.unique(seen.pose).tolist():
        parts = []
        for association in decisions.keys[number].associations:
            mine = association.spline == spline.id
            parts += _parts(association, *next(pieces), edit.new) if mine else [association]
        decisions = decisions.with_associations(number, tuple(parts))
    return decisions


def _part(spline: MapSpline, number: int, span: tuple[float, float], model: Model) -> MapSpline:
    history = (*spline.history, f"split by hand: {number} has {spline.curve.length(span):.2f} m of it")
    return replace(spline, id=number, curve=model.cut(spline.curve, span), span=span, history=history)


def _parts(
    association: Association, beams: Int[np.ndarray, "m"], passed: Bool[np.ndarray, "m"], new: int
) -> Iterator[Association]:
    """An association cut where its beams pass into the spline `new`."""
    before = int(np.count_nonzero(~passed))
    if before:
        yield replace(association, last=int(beams[before - 1]))
    if before < len(beams):
        yield replace(association, first=int(beams[before]), spline=new)


def merge_splines(decisions: Decisions, edit: MergeSplines, model: Model) -> Decisions:
    """What was given to one spline held to the other, which is lengthened to reach as far as both did."""
    if edit.kept == edit.gone:
        raise EditError(f"spline {edit.kept} cannot be merged into itself")
    kept, gone = decisions.spline(edit.kept), decisions.spline(edit.gone)
    t, samples = gone.sample(SAMPLING)
    feet = kept.curve.foot_points(samples)
    if float((gone.curve.normals(t) * kept.curve.normals(feet)).sum(1).mean()) < 0.0:
        raise EditError(f"splines {kept.id} and {gone.id} face opposite ways: they are two sides of something")
    gap = float(np.linalg.norm(samples[:, None] - kept.sample(SAMPLING)[1], axis=-1).min())
    if gap > WIDEST_GAP:
        raise EditError(f"splines {kept.id} and {gone.id} lie {gap:.2f} m apart")
    merged = lengthened_through(kept, samples, model)
    history = (*kept.history, f"merged by hand with spline {gone.id}")
    left_out = max(kept.left_out, gone.left_out)
    merged = replace(merged, born=min(kept.born, gone.born), history=history, left_out=left_out)
    decisions = decisions.with_spline(merged).without_spline(gone.id)
    for number, key in enumerate(decisions.keys):
        if any(association.spline == gone.id for association in key.associations):
            renamed = (replace(a, spline=kept.id, by="hand") if a.spline == gone.id else a for a in key.associations)
            decisions = decisions.with_associations(number, tuple(renamed))
    return decisions


def pin_spline(decisions: Decisions, edit: PinSpline) -> Decisions:
    """The spline with the curve that it is pinned to."""
    spline = decisions.spline(edit.spline)
    history = (*spline.history, "pinned by hand")
    pinned = replace(spline, curve=edit.curve, span=edit.span, history=history)
    pins = {**decisions.spline_pins, spline.id: edit.curve.control_points}
    others = tuple(pinned if one.id == spline.id else one for one in decisions.splines)
    same = spline.curve.degree == edit.degree and np.array_equal(spline.curve.knots, edit.knots)
    same = same and spline.span == edit.span
    moved = replace(decisions, splines=SplineMap(others)) if same else decisions.with_spline(pinned)
    return replace(moved, spline_pins=pins)


def lengthened_through(spline: MapSpline, points: Float[np.ndarray, "m 2"], model: Model) -> MapSpline:
    """The spline drawn on through those of the world points, in their order, that lie beyond one of its ends.

    What of the points lies beside the spline says how far they are shifted onto it first. The spline itself where no
    point lies beyond, or only beyond too wide a gap.
    """
    curve, ends = spline.curve, np.array(spline.span)
    (first, last), tangents = curve(ends), curve(ends, 1)
    t = curve.foot_points(points)
    before = (t <= ends[0] + ROUNDING) & _beyond(points, first, -tangents[0])
    after = (t >= ends[1] - ROUNDING) & _beyond(points, last, tangents[1])
    samples = spline.sample(SAMPLING)[1]
    shifted = points + _aside(spline, t, points, ~(before | after))
    head, tail = _near(shifted[before][::-1], first)[::-1], _near(shifted[after], last)
    if len(head) + len(tail) == 0:
        return spline
    drawn = np.concatenate([head, samples, tail])
    return replace(spline, curve=model.through(drawn), span=(0.0, float(cumulated_chords(drawn)[-1])))


def _beyond(
    points: Float[np.ndarray, "m 2"], end: Float[np.ndarray, "2"], out: Float[np.ndarray, "2"]
) -> Bool[np.ndarray, "m"]:
    """Points that lie farther out than the end of a curve that leaves there in this direction."""
    return (points - end) @ (out / max(float(np.linalg.norm(out)), 1e-12)) > BEYOND


def _aside(
    spline: MapSpline, t: Float[np.ndarray, "m"], points: Float[np.ndarray, "m 2"], beside: Bool[np.ndarray, "m"]
) -> Float[np.ndarray, "2"]:
    """The mean way from points beside a spline to their feet on it; none where there are none."""
    if not beside.any():
        return np.zeros(2)
    return (spline.curve(t[beside]) - points[beside]).mean(0)


def _near(points: Float[np.ndarray, "m 2"], end: Float[np.ndarray, "2"]) -> Float[np.ndarray, "k 2"]:
    """The points, in the order in which they leave an end, as far as no wide gap lies between them."""
    steps = np.linalg.norm(np.diff(np.concatenate([end[None], points]), axis=0), axis=1)
    wide = np.flatnonzero(steps > WIDEST_GAP)
    return points[: wide[0]] if len(wide) else points
