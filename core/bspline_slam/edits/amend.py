"""The map that hand edits make of an automatic result: a pure function of the result and the edits in force.

Edits of what ties poses come first, for a loop closure may move the whole map; where it does, that is built anew and
adjusted. Then come the others in their order, and solving from where the map was: what edits changed is linearised
where the map is, again and again until nothing moves, and so is what they moved far; all the rest stays as it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bspline_slam.adjustment.adjust import usual_records, with_estimate
from bspline_slam.adjustment.trimming import on_stretch, trimmed
from bspline_slam.backends import Stopping, back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, never
from bspline_slam.corners import LOOSE, corners_of, meeting
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
from bspline_slam.edits.problem import FAR, Changes, changed_graph, held_by_hand, linearised, moved_units
from bspline_slam.edits.spline_edits import merge_splines, pin_spline, split_spline
from bspline_slam.edits.ties import Tie, Ties, tie
from bspline_slam.errors import Cancelled, EditError, SolverError
from bspline_slam.front_end.tracking import carried_along
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.slam import SlamConfig, Snapshot, StageProgress, quiet
from bspline_slam.spline_map import SplineMap

MOST_ROUNDS = 10
AT_REST = 1e-4
"""Rounds end when none of the key poses moves by more than this (m, rad), or when the moves no longer fall."""
FALLING = 0.75
"""The largest move of a key pose falls to less than this share of it within two rounds, or it no longer falls: where
beams enter and leave the gate of a curve that slides along itself, each round would move a little for ever."""
WARM = Stopping(decrease=1e-7, move=1e-5, iterations=20)
"""Rounds before the last."""


@dataclass(frozen=True, eq=False, slots=True)
class Amended:
    """The result with edits, of each edit why it could not be made (None: it was made), and the ground that more edits
    can start from (None for a result without edits)."""

    snapshot: Snapshot
    skipped: tuple[str | None, ...]
    ground: Ground | None = None


def amended(
    base: Snapshot,
    edits: Sequence[Edit],
    config: SlamConfig,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
    ground: Ground | None = None,
    ties: Ties | None = None,
) -> Amended:
    """The finished automatic result with edits; without any, itself. Raises SolverError, Cancelled.

    `ground` is that of the result, where it is at hand; `ties` what is remembered of edits of it.
    """
    if not edits:
        return Amended(base, ())
    ground = ground or Ground.of(base, config)
    ground, decisions, skipped = decide(ground, base, edits, progress, cancelled, ties)
    decisions, estimate = settled(ground, decisions, progress, cancelled)
    after = replace(decisions, touched=frozenset(), reshaped=frozenset())
    return Amended(_snapshot(base, decisions, estimate), skipped, replace(ground, decisions=after, estimate=estimate))


def solved_again(
    amended: Snapshot, name: str, progress: StageProgress = quiet, cancelled: Cancelling = never
) -> Snapshot:
    """A result with edits, the problem that these left solved by the back end `name`. Its beams are not sought anew on
    the curves, for some are held where a person put them. Raises SolverError, Cancelled."""
    if amended.estimate is None:
        raise SolverError("edits amend a finished map, and this one was never adjusted")
    usual = usual_records(name, len(amended.key_scans))

    def note(record: IterationRecord) -> None:
        progress("adjustment", min(record.index, usual - 1) / usual, record)

    estimate = back_end(name).solve(amended.estimate.graph, progress=note, cancelled=cancelled)
    decisions, joints = _moved(Decisions.of(amended), estimate), [corner.joint for corner in corners_of(amended.map)]
    return _snapshot(amended, replace(decisions, splines=meeting(decisions.splines, joints)), estimate)


# -- decisions -----------------------------------------------------------------------------------------------------
def decide(
    ground: Ground,
    base: Snapshot,
    edits: Sequence[Edit],
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
    ties: Ties | None = None,
) -> tuple[Ground, Decisions, tuple[str | None, ...]]:
    """The decisions with edits made in them, and of each edit why it could not be made; where a loop closure moves the
    map, on another ground."""
    tied = (ties or Ties()).made(ground, edits, [step.lost for step in base.steps], progress, cancelled)
    ground, decisions, early = tied.ground, tied.decisions, iter(tied.skipped)
    skipped: list[str | None] = []
    for edit in edits:
        reason = None
        if isinstance(edit, Tie):
            reason = next(early)
        else:
            try:
                decisions = edited(ground, decisions, edit)
            except EditError as error:
                reason = str(error)
        skipped.append(reason)
    return ground, _supported(ground, decisions), tuple(skipped)


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


def _supported(ground: Ground, decisions: Decisions) -> Decisions:
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


# -- solving -------------------------------------------------------------------------------------------------------
def settled(
    ground: Ground, decisions: Decisions, progress: StageProgress = quiet, cancelled: Cancelling = never
) -> tuple[Decisions, Estimate]:
    """Solve, and linearise what is loose anew, until nothing moves: the decisions at the optimum, and the estimate.

    Loose are beams that a person holds to a spline, and what has moved far since it was linearised.
    """
    changes, loose = Changes.of(ground, decisions), True
    joints = {corner.joint for each in (ground.decisions, decisions) for corner in corners_of(each.splines)}
    held, number, moves = held_by_hand(decisions, changes), 0, (np.inf, np.inf)
    new, place = linearised(ground, decisions, changes), decisions.poses
    while loose and number < MOST_ROUNDS:
        if cancelled():
            raise Cancelled("the edits were cancelled")

        def note(record: IterationRecord, number: int = number) -> None:
            progress("edits", (number + min(record.index, 4) / 5) / MOST_ROUNDS, record)

        graph = changed_graph(ground, decisions, changes, new)
        estimate = back_end("direct", WARM).solve(graph, progress=note, cancelled=cancelled)
        step, decisions = estimate.poses - decisions.poses, _moved(decisions, estimate)
        number, more = number + 1, moved_units(ground, decisions, changes)
        far = np.abs(decisions.poses - place).max() > FAR
        move = float(np.abs(step).max())
        loose = goes_on(move, moves[0]) and (held or far or bool(more))
        moves = (moves[1], move)
        if loose:
            changes = changes.with_units(more)
            new, place = linearised(ground, decisions, changes), decisions.poses
    estimate = back_end("direct").solve(changed_graph(ground, decisions, changes, new), cancelled=cancelled)
    decisions = _moved(decisions, estimate)
    return replace(decisions, splines=meeting(decisions.splines, sorted(joints))), estimate


def goes_on(move: float, before: float) -> bool:
    """Whether rounds still lead somewhere: key poses moved by `move` in the last and by `before` two rounds earlier."""
    return AT_REST < move < FALLING * before


def _moved(decisions: Decisions, estimate: Estimate) -> Decisions:
    return replace(decisions, poses=estimate.poses, splines=with_estimate(decisions.splines, estimate))


def _snapshot(base: Snapshot, decisions: Decisions, estimate: Estimate) -> Snapshot:
    """The result as a whole; scans between key scans go along with these."""
    before = np.array([step.pose for step in base.steps])
    steps = tuple(
        replace(step, pose=pose, associations=key.associations)
        for step, pose, key in zip(base.steps, decisions.poses, decisions.keys, strict=True)
    )
    splines = tuple(
        replace(spline, observations=_given_to(decisions, spline.id)) if spline.id in decisions.touched else spline
        for spline in decisions.splines
    )
    return replace(
        base,
        poses=carried_along(base.poses, base.key_scans, before, decisions.poses),
        steps=steps,
        map=SplineMap(splines),
        loop_closures=decisions.closures,
        estimate=estimate,
        observations=decisions.keys,
        pose_factors=decisions.factors,
    )


def _given_to(decisions: Decisions, spline: int) -> int:
    """How many key scans have a piece that was given to the spline."""
    return sum(any(a.spline == spline for a in key.associations) for key in decisions.keys)
