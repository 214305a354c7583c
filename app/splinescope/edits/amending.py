"""A result of which some decisions were made by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from bspline_slam.association import Association
from bspline_slam.edits.edit import Edit
from bspline_slam.slam import SlamStep
from splinescope.computing.edit_messages import EditsMade
from splinescope.result import Result


def amended_result(base: Result, edits: tuple[Edit, ...], made: EditsMade) -> Result:
    """A result with edits, as they were made; nothing of it is measured yet."""
    snapshot = made.snapshot
    if made.same_closures:
        snapshot = replace(snapshot, loop_closures=base.snapshot.loop_closures)
    return Result(
        number=base.number,
        recipe=base.recipe,
        snapshot=snapshot,
        steps=amended_steps(base.steps, made.associations),
        processed=base.processed,
        kept=base.kept,
        solution=made.solution or base.solution,
        origin=base.origin,
        stopped_after=base.stopped_after,
        edits=edits,
    )


def amended_steps(
    steps: Mapping[int, SlamStep], associations: Mapping[int, tuple[Association, ...]]
) -> dict[int, SlamStep]:
    """Steps with other associations for some of them."""
    changed = {scan: replace(steps[scan], associations=told) for scan, told in associations.items() if scan in steps}
    return {**steps, **changed}
