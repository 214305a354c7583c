"""What edits would do, looked at before they are accepted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bspline_slam import se2
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, DropLoop, Edit, Force, MakeNew, OnPiece
from bspline_slam.edits.explain import rms
from bspline_slam.edits.footing import Footing
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.loop_edits import moved_poses
from bspline_slam.edits.making import edited
from bspline_slam.edits.piece_edits import facing
from bspline_slam.edits.quick import Answer, answer
from bspline_slam.errors import EditError, as_sentence
from bspline_slam.front_end.mapping import carried
from bspline_slam.slam import SlamConfig, Snapshot
from bspline_slam.spline_map import SplineMap
from splinescope.computing.edit_messages import Preview
from splinescope.computing.ghosts import ghost_of

MOST_ROWS = 6
"""Rows of a preview on what pieces are about."""


@dataclass(frozen=True, eq=False, slots=True)
class Before:
    """What edits are looked at from: a footing, the decisions with edits in force that are not settled yet, and the
    result that the page shows."""

    footing: Footing
    decisions: Decisions
    shown: Snapshot


def with_edits(ground: Ground, decisions: Decisions, edits: tuple[Edit, ...]) -> tuple[Decisions, str | None]:
    """The decisions with more edits, or why they cannot be made."""
    before = decisions
    try:
        for edit in edits:
            decisions = edited(ground, decisions, edit)
    except EditError as error:
        return before, as_sentence(str(error))
    return decisions, None


def preview(before: Before, proposed: tuple[Edit, ...], tell: Callable[[Preview], None]) -> None:
    """Tell what edits would do, as soon as it is known and then better."""
    ground = before.footing.ground
    decided, reason = with_edits(ground, before.decisions, proposed)
    if reason is not None:
        tell(Preview(refusal=reason, final=True))
        return
    held = [row for edit in proposed for row in held_apart(edit, proposed, before.decisions, ground.config)][:MOST_ROWS]
    moved = bent(before, proposed, decided)
    if moved is not None:
        away = float(np.linalg.norm((moved.poses - before.decisions.poses)[:, :2], axis=1).max())
        rows = (*held, ("largest move of a pose", f"{away:.2f} m"), ("then", "the map is built anew and adjusted"))
        tell(Preview(rows, ghost_of(before.shown, moved), None, True))
        return

    def told(found: Answer) -> None:
        rows = (
            *held,
            ("predicted change of cost", f"{found.cost_change:+,.1f}"),
            ("largest move of a pose", f"{1000 * found.largest_move:.1f} mm"),
        )
        tell(Preview(rows, ghost_of(before.shown, found.decisions), None, found.at_rest))

    last = answer(before.footing, decided, told)
    told(replace(last, at_rest=True))


def bent(before: Before, edits: tuple[Edit, ...], decided: Decisions) -> Decisions | None:
    """What loop closures among edits that move the whole map do to it, by the pose graph alone; None where there are
    none."""
    if not any(isinstance(edit, CloseLoop | DropLoop) for edit in edits):
        return None
    poses = moved_poses(before.decisions, decided, before.footing.ground.config)
    if poses is None:
        return None
    was = decided.poses
    moves = se2.compose(poses, se2.inverse(was))
    splines = (
        replace(spline, curve=spline.curve.with_control_points(carried(spline.curve.control_points, was[:, :2], moves)))
        for spline in decided.splines
    )
    return replace(decided, poses=poses, splines=SplineMap(tuple(splines)))


def distances(edit: Edit, decisions: Decisions, config: SlamConfig) -> list[tuple[str, str]]:
    """How far a piece lies from the spline that it is to be given to, and how much of it lies beside that."""
    if not isinstance(edit, Force) or edit.spline not in decisions.splines:
        return [("beams", str(len(decisions.points(edit))))] if isinstance(edit, OnPiece | MakeNew) else []
    points, off = decisions.points(edit), facing(decisions, edit)
    distance = "it lies beyond its end, or behind it"
    if len(off):
        distance = f"{1000 * rms(off):.0f} mm (gate {1000 * config.association.gate:.0f} mm)"
    return [("distance", distance), ("overlap", f"{len(off) / len(points):.0%} of {len(points)} beams")]


def held_apart(edit: Edit, among: tuple[Edit, ...], decisions: Decisions, config: SlamConfig) -> list[tuple[str, str]]:
    """Distances, named by the segment where several edits are proposed."""
    segment = f"segment {edit.segment}, " if len(among) > 1 and isinstance(edit, OnPiece) else ""
    return [(segment + name, value) for name, value in distances(edit, decisions, config)]
