"""The map that hand edits make of an automatic result: a pure function of the result and the edits in force.

Each edit is made in the map that the edits before it left, and solving starts there: what it changed is linearised
where the map is, again and again until nothing moves, and so is what it moved far; all the rest stays as it was.
Edits of pieces of one scan that follow each other are made together. A loop closure that moves the whole map has that
built anew from the automatic result: first come all ties of poses then, on them all other edits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bspline_slam.adjustment.adjust import usual_records, with_estimate
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, never
from bspline_slam.corners import corners_of, meeting
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, DropLoop, Edit, OnPiece, SplitSegment
from bspline_slam.edits.footing import Footing
from bspline_slam.edits.loop_edits import moved_poses
from bspline_slam.edits.making import decided
from bspline_slam.edits.settling import settled
from bspline_slam.edits.states import Amended, States
from bspline_slam.edits.ties import Tie
from bspline_slam.errors import SolverError
from bspline_slam.slam import SlamConfig, Snapshot, StageProgress, quiet
from bspline_slam.spline_map import SplineMap


def amended(
    base: Snapshot,
    edits: Sequence[Edit],
    config: SlamConfig,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
    states: States | None = None,
) -> Amended:
    """The finished automatic result with edits; without any, itself. Raises SolverError, Cancelled.

    `states` are the results with edits that are remembered of it: the longest beginning among them is gone on from.
    """
    states = states or States(base, config)
    edits = tuple(edits)
    ends = steps_of(edits)
    known = max(end for end in (0, *ends) if edits[:end] in states)
    made = states[edits[:known]]
    ahead = [end for end in ends if end > known]
    for number, (start, end) in enumerate(zip([known, *ahead], ahead, strict=False)):

        def told(stage: str, fraction: float, record: IterationRecord | None, number: int = number) -> None:
            progress(stage, (number + fraction) / len(ahead), record)

        made, footing = _stepped(states, made, edits[:end], end - start, told, cancelled)
        states.keep(edits[:end], made, footing)
    return made


def steps_of(edits: Sequence[Edit]) -> list[int]:
    """Where the steps end in which edits are made: each edit is one, or all pieces of one scan that come together."""
    return [
        k
        for k in range(1, len(edits) + 1)
        if k == len(edits) or (scan := _scan_of(edits[k])) is None or scan != _scan_of(edits[k - 1])
    ]


def _scan_of(edit: Edit) -> int | None:
    """The scan that a piece to be edited belongs to; None for edits of anything else."""
    return edit.scan if isinstance(edit, OnPiece | SplitSegment) else None


def _stepped(
    states: States, before: Amended, edits: tuple[Edit, ...], count: int, progress: StageProgress, cancelled: Cancelling
) -> tuple[Amended, Footing]:
    """The result with edits, the last `count` of which are not in the result before."""
    decisions, skipped = decided(before.ground, before.ground.decisions, edits[-count:])
    ties = any(isinstance(edit, CloseLoop | DropLoop) for edit in edits[-count:])
    if ties and moved_poses(before.ground.decisions, decisions, states.config) is not None:
        return _built_anew(states, edits, progress, cancelled)
    footing = settled(before.ground, decisions, progress, cancelled)
    return _amended(before.snapshot, footing, (*before.skipped, *skipped))


def _built_anew(
    states: States, edits: tuple[Edit, ...], progress: StageProgress, cancelled: Cancelling
) -> tuple[Amended, Footing]:
    """The result with edits, made of the automatic one: ties of poses first, whose map is built anew where they bend
    it, then all others."""
    base = states.base
    lost = [step.lost for step in base.steps]
    tied = states.ties.made(states[()].ground, edits, lost, progress, cancelled)
    others = [edit for edit in edits if not isinstance(edit, Tie)]
    decisions, late = decided(tied.ground, tied.decisions, others)
    footing = settled(tied.ground, decisions, progress, cancelled)
    early, late = iter(tied.skipped), iter(late)
    skipped = tuple(next(early if isinstance(edit, Tie) else late) for edit in edits)
    return _amended(base, footing, skipped)


def _amended(before: Snapshot, footing: Footing, skipped: tuple[str | None, ...]) -> tuple[Amended, Footing]:
    """The result that was settled after `before`, and the footing that more edits start from."""
    ground = footing.ground
    snapshot = _snapshot(before, ground.decisions, ground.estimate)
    decisions = replace(ground.decisions, splines=snapshot.map, touched=frozenset(), reshaped=frozenset())
    ground = replace(ground, decisions=decisions)
    return Amended(snapshot, skipped, ground), replace(footing, ground=ground)


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
    before, joints = Decisions.of(amended), [corner.joint for corner in corners_of(amended.map)]
    splines = meeting(with_estimate(before.splines, estimate), joints)
    return _snapshot(amended, replace(before, poses=estimate.poses, splines=splines), estimate)


def _snapshot(base: Snapshot, decisions: Decisions, estimate: Estimate) -> Snapshot:
    """The result as a whole; scans between key scans go along with these."""
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
        poses=base.poses_with(decisions.poses),
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
