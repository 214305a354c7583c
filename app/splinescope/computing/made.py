"""A result with edits as the page gets it."""

from __future__ import annotations

from dataclasses import replace

from bspline_slam.edits.explain import Explanation
from bspline_slam.edits.states import Amended
from bspline_slam.slam import Snapshot
from splinescope.computing.edit_messages import EditsMade
from splinescope.computing.messages import for_looking_at
from splinescope.computing.solution import Solution


def made_message(job: int, base: Snapshot, made: Amended, told: Explanation | None, seconds: float) -> EditsMade:
    """The result with edits; what is as in the result without is not sent again."""
    after = made.snapshot
    changed = {
        new.scan: new.associations
        for old, new in zip(base.observations, after.observations, strict=True)
        if new is not old
    }
    same = after.loop_closures is base.loop_closures
    snapshot = for_looking_at(replace(after, loop_closures=()) if same else after)
    return EditsMade(job, snapshot, changed, told, solution(after, told, seconds), same)


def solution(after: Snapshot, told: Explanation | None, seconds: float) -> Solution | None:
    """The figures of the solve behind a result with edits."""
    estimate = after.estimate
    if estimate is None or told is None:
        return None
    return Solution(
        back_end="direct",
        cost_before=sum(told.before.values()),
        cost_after=sum(told.after.values()),
        largest_move=float(told.moves.max(initial=0.0)),
        chi2=float(estimate.chi2),
        dof=round(estimate.dof),
        costs=tuple(float(record.cost) for record in estimate.iterations),
        converged=estimate.converged,
        seconds=seconds,
    )
