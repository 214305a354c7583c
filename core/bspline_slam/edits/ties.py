"""What edits of ties between poses make of a ground: the map as it is, or built anew where they move it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from bspline_slam.backends.protocol import Cancelling, never
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, DropLoop, Edit, PinPose
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.loop_edits import close_loop, drop_loop, moved_poses, pin_pose, rebuilt
from bspline_slam.errors import EditError
from bspline_slam.slam import SlamConfig, StageProgress, quiet

Tie = CloseLoop | DropLoop | PinPose
KEPT = 3
"""So many are remembered, for a map that is built anew takes seconds."""


@dataclass(frozen=True, eq=False, slots=True)
class Tied:
    """The decisions after edits of ties, the ground that other edits start from, and of each edit why it could not be
    made (None: it was made)."""

    ground: Ground
    decisions: Decisions
    skipped: tuple[str | None, ...]


@dataclass
class Ties:
    """State: what the latest edits of ties made, for edits of anything else leave that as it is."""

    _kept: list[tuple[Ground, tuple[Tie, ...], Tied]] = field(default_factory=list)

    def made(
        self,
        ground: Ground,
        edits: Sequence[Edit],
        lost: Sequence[bool],
        progress: StageProgress = quiet,
        cancelled: Cancelling = never,
    ) -> Tied:
        """The edits of ties among these made; `lost` are key scans that saw nothing. Raises SolverError, Cancelled."""
        ties = tuple(edit for edit in edits if isinstance(edit, Tie))
        known = next((tied for start, made, tied in self._kept if start is ground and made == ties), None)
        tied = known or tied_by(ground, ties, lost, progress, cancelled)
        others = [each for each in self._kept if each[2] is not tied]
        self._kept = [*others, (ground, ties, tied)][-KEPT:]
        return tied


def tied_by(
    ground: Ground, ties: Sequence[Tie], lost: Sequence[bool], progress: StageProgress, cancelled: Cancelling
) -> Tied:
    """These edits made; where a loop closure moves the map, on another ground. Raises SolverError, Cancelled."""
    decisions, skipped = ground.decisions, []
    for edit in ties:
        reason = None
        try:
            decisions = tie(decisions, edit, ground.config)
        except EditError as error:
            reason = str(error)
        skipped.append(reason)
    if decisions.factors != ground.decisions.factors:
        poses = moved_poses(ground.decisions, decisions, ground.config)
        if poses is not None:
            bent = replace(decisions, poses=poses)
            decisions, estimate = rebuilt(bent, lost, ground.config, ground.model, progress, cancelled)
            ground = Ground.at(replace(decisions, pose_pins={}), estimate, ground.config)
    return Tied(ground, decisions, tuple(skipped))


def tie(decisions: Decisions, edit: Tie, config: SlamConfig) -> Decisions:
    """The decisions with one such edit more. Raises EditError where it cannot be made."""
    match edit:
        case PinPose():
            return pin_pose(decisions, edit)
        case CloseLoop():
            return close_loop(decisions, edit, config)
        case DropLoop():
            return drop_loop(decisions, edit)
