"""Edits made in decisions, one after another; what they leave of curves that nobody drew by hand."""

from __future__ import annotations

from collections.abc import Sequence

from bspline_slam.adjustment.trimming import on_stretch, trimmed
from bspline_slam.corners import LOOSE, corners_of
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import (
    CloseLoop,
    DropLoop,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    MergeSplines,
    PinPose,
    PinSpline,
    SplitSegment,
    SplitSpline,
)
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.piece_edits import forbid, force, ignore, make_new, split_segment
from bspline_slam.edits.spline_edits import merge_splines, pin_spline, split_spline
from bspline_slam.edits.ties import tie
from bspline_slam.errors import EditError
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.spline_map import SplineMap


def decided(ground: Ground, decisions: Decisions, edits: Sequence[Edit]) -> tuple[Decisions, tuple[str | None, ...]]:
    """The decisions with edits made in them, and of each edit why it could not be made (None: it was made)."""
    skipped: list[str | None] = []
    for edit in edits:
        reason = None
        try:
            decisions = edited(ground, decisions, edit)
        except EditError as error:
            reason = str(error)
        skipped.append(reason)
    return supported(ground, decisions), tuple(skipped)


def edited(ground: Ground, decisions: Decisions, edit: Edit) -> Decisions:
    """The decisions with one edit more. Raises EditError where it cannot be made."""
    model = ground.model
    match edit:
        case Force():
            return force(decisions, edit, model)
        case Forbid():
            return forbid(decisions, edit)
        case MakeNew():
            return make_new(decisions, edit, model)
        case Ignore():
            return ignore(decisions, edit)
        case SplitSegment():
            return split_segment(decisions, edit)
        case SplitSpline():
            return split_spline(decisions, edit, model)
        case MergeSplines():
            return merge_splines(decisions, edit, model)
        case PinSpline():
            return pin_spline(decisions, edit)
        case PinPose() | CloseLoop() | DropLoop():
            return tie(decisions, edit, ground.config)


def supported(ground: Ground, decisions: Decisions) -> Decisions:
    """Splines that were given other beams, cut back to what is seen often enough; those that a person gave beams or
    drew stay as they are, and those of which hardly anything would be left."""
    by_hand = {a.spline for key in decisions.keys for a in key.associations if a.by == "hand"}
    loose = decisions.touched - decisions.reshaped - by_hand
    chosen = SplineMap(tuple(spline for spline in decisions.splines if spline.id in loose))
    if not len(chosen):
        return decisions
    adjustment, sights = ground.config.adjustment, collect_sights(decisions.keys, chosen)
    feet = find_feet(sights, chosen, decisions.poses, adjustment.gates[-1])
    cut = trimmed(chosen, sights, feet, adjustment.trimming, ground.model)
    before = {spline.id: spline for spline in chosen}
    corners = corners_of(ground.decisions.splines)
    ended, started = {corner.before for corner in corners}, {corner.after for corner in corners}
    for after in cut:
        whole = before[after.id]
        span = (
            _at_corner(whole.span[0], after.span[0]) if after.id in started else after.span[0],
            _at_corner(whole.span[1], after.span[1]) if after.id in ended else after.span[1],
        )
        if span != whole.span:
            decisions = decisions.with_spline(on_stretch(whole, span, ground.model))
    return decisions


def _at_corner(corner: float, seen: float) -> float:
    """Where a spline ends that met another at the parameter `corner` and is seen up to another one."""
    return corner if abs(seen - corner) <= LOOSE else seen
