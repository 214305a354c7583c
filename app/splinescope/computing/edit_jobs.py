"""What the editor's process does: preview edits, make them, match scans for a loop closure."""

from __future__ import annotations

import pickle
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.edits.amend import Amended, amended, edited
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.doubts import doubts
from bspline_slam.edits.edit import CloseLoop, DropLoop, Edit, Force, MakeNew, OnPiece
from bspline_slam.edits.explain import Explanation, explain
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.loop_edits import moved_poses
from bspline_slam.edits.loop_match import match_loop
from bspline_slam.edits.piece_edits import across
from bspline_slam.edits.quick import Answer, Footing, answer
from bspline_slam.edits.ties import Ties
from bspline_slam.errors import Cancelled, EditError
from bspline_slam.front_end.mapping import carried
from bspline_slam.front_end.tracking import carried_along
from bspline_slam.slam import SlamConfig, Snapshot, StageProgress, quiet
from bspline_slam.spline_map import SplineMap
from splinescope.computing.edit_messages import (
    DoubtsFound,
    EditRequest,
    EditsMade,
    FindPreview,
    Ghost,
    LoopMatched,
    MakeEdits,
    MatchLoop,
    Prepare,
    Preview,
    PreviewFound,
    QuickAnswer,
)
from splinescope.computing.messages import Message, for_looking_at
from splinescope.computing.reporter import Reporter, failures_told
from splinescope.computing.solution import Solution

MOST_ROWS = 6
"""Rows of a preview on what pieces are about."""
KEPT = 8
"""So many states are remembered: to undo and to redo takes no time."""
MOMENT = 0.3
"""What takes no longer than this (s) is not told of while it goes on."""
MOVED = 1e-3
"""What moves by less than this (m) is not in the ghost."""


@dataclass(frozen=True, eq=False, slots=True)
class Solved:
    """A result with edits, and what the solver did with them."""

    edits: tuple[Edit, ...]
    amended: Amended
    explanation: Explanation | None


@dataclass(frozen=True, eq=False, slots=True)
class Made:
    """A result with edits, and the footing that more edits start from."""

    solved: Solved
    footing: Footing

    @property
    def amended(self) -> Amended:
        return self.solved.amended


class Jobs:
    """Does one request after the other. State: the automatic result, the latest results with edits, and the edits that
    were looked at last with the ghost of what they do."""

    def __init__(self, send: Callable[[Message], None]) -> None:
        self._send = send
        self._base: Snapshot | None = None
        self._config = SlamConfig()
        self._made: OrderedDict[tuple[Edit, ...], Made] = OrderedDict()
        self._looked_at: tuple[FindPreview, Ghost] | None = None
        self._ties = Ties()

    def do(self, request: EditRequest, cancelled: Callable[[], bool]) -> None:
        """Do a request; whatever goes wrong in it is sent as a sentence."""
        with failures_told(request.job, self._send, "editor"):
            if isinstance(request, Prepare) or not cancelled():
                self._do(request, cancelled)

    def _do(self, request: EditRequest, cancelled: Callable[[], bool]) -> None:
        match request:
            case Prepare(kept=kept, config=config):
                self._base, self._config = pickle.loads(kept), config
                self._made.clear()
                self._looked_at, self._ties = None, Ties()
                self._state((), cancelled)
                self._send(DoubtsFound(request.job, doubts(self._whole, config)))
            case FindPreview(in_force=in_force, proposed=proposed):
                state = self._state(in_force, cancelled)
                preview(self._whole, state, proposed, lambda p: self._tell_preview(request, p))
            case MakeEdits():
                self._make(request, cancelled)
            case MatchLoop(in_force=in_force, earlier=earlier, scan=scan, guess=guess):
                decisions = self._state(in_force, cancelled).footing.ground.decisions
                found = match_loop(decisions, earlier, scan, guess, self._config)
                self._send(
                    LoopMatched(
                        request.job, found.measured, found.sqrt_information, found.score, found.inliers, found.sentence
                    )
                )

    @property
    def _whole(self) -> Snapshot:
        if self._base is None:
            raise EditError("the editor has lost the result that is to be edited")
        return self._base

    def _tell_preview(self, request: FindPreview, found: Preview) -> None:
        if found.ghost is not None:
            self._looked_at = (request, found.ghost)
        self._send(PreviewFound(request.job, found))

    def _state(
        self,
        edits: tuple[Edit, ...],
        cancelled: Callable[[], bool],
        tell: Callable[[Solved], None] = lambda _: None,
        progress: StageProgress = quiet,
    ) -> Made:
        """The result with these edits: remembered, or made; `tell` is told of it before the rest is made ready."""
        made = self._made.get(edits)
        if made is None:
            base, ground = self._whole, self._made[()].footing.ground if self._made else None
            done = amended(base, edits, self._config, progress, cancelled, ground=ground, ties=self._ties)
            told = explain(base, done.snapshot, edits, done.skipped, self._config) if edits else None
            solved = Solved(edits, done, told)
            tell(solved)
            made = Made(solved, Footing.of(done.ground or ground or Ground.of(base, self._config)))
            self._made[edits] = made
        else:
            tell(made.solved)
        self._made.move_to_end(edits)
        while len(self._made) > KEPT:
            oldest = next(key for key in self._made if key != ())
            del self._made[oldest]
        return made

    def _make(self, request: MakeEdits, cancelled: Callable[[], bool]) -> None:
        job, start = request.job, time.monotonic()

        def tell(solved: Solved) -> None:
            if cancelled():
                raise Cancelled("newer edits are on their way")
            self._send(made_message(job, self._whole, solved, time.monotonic() - start))

        self._glimpse(request)
        state = self._state(request.edits, cancelled, tell, slow(Reporter(job, self._send)))
        if cancelled():
            raise Cancelled("newer edits are on their way")
        self._send(DoubtsFound(job, doubts(state.amended.snapshot, self._config)))

    def _glimpse(self, request: MakeEdits) -> None:
        """The quick answer where there is none better: as it was looked at, or from the nearest state before."""
        job, edits, shown = request.job, request.edits, self._made.get(request.shown)
        if self._looked_at is not None:
            asked, ghost = self._looked_at
            if asked.in_force == request.shown and (*asked.in_force, *asked.proposed) == edits:
                self._send(QuickAnswer(job, ghost))
                return
        known = max(size for size in range(len(edits) + 1) if edits[:size] in self._made or size == 0)
        before, more = self._made.get(edits[:known]), edits[known:]
        if before is None or shown is None or not more or any(isinstance(e, CloseLoop | DropLoop) for e in more):
            return
        decisions, reason = with_edits(before.footing.ground, more)
        if reason is None:
            now = shown.amended.snapshot
            answer(before.footing, decisions, lambda f: self._send(QuickAnswer(job, ghost_of(now, f.decisions))))


def slow(reporter: Reporter) -> StageProgress:
    """Tells progress of what takes longer than a moment."""
    start = time.monotonic()

    def progress(stage: str, fraction: float, record: IterationRecord | None) -> None:
        if time.monotonic() - start > MOMENT:
            reporter.progress(stage, fraction)

    return progress


def with_edits(ground: Ground, edits: tuple[Edit, ...]) -> tuple[Decisions, str | None]:
    """The decisions of a ground with more edits, or why they cannot be made."""
    decisions = ground.decisions
    try:
        for edit in edits:
            decisions = edited(ground, decisions, edit)
    except EditError as error:
        return ground.decisions, f"{str(error)[:1].upper()}{str(error)[1:]}."
    return decisions, None


def poses_at(snapshot: Snapshot, decisions: Decisions) -> Float[np.ndarray, "scans 3"]:
    """The poses of all scans when the key poses of a snapshot go to those of decisions."""
    before = np.array([step.pose for step in snapshot.steps])
    return carried_along(snapshot.poses, snapshot.key_scans, before, decisions.poses)


# -- preview -------------------------------------------------------------------------------------------------------
def preview(base: Snapshot, state: Made, proposed: tuple[Edit, ...], tell: Callable[[Preview], None]) -> None:
    """Tell what edits would do, as soon as it is known and then better."""
    ground = state.footing.ground
    decisions, reason = with_edits(ground, proposed)
    if reason is not None:
        tell(Preview(refusal=reason, final=True))
        return
    held = [row for edit in proposed for row in held_apart(edit, proposed, ground.decisions, ground.config)][:MOST_ROWS]
    moved = None
    if any(isinstance(edit, CloseLoop | DropLoop) for edit in proposed):
        moved = moved_poses(ground.decisions, decisions, ground.config)
    if moved is not None:
        tell(_bent(state, moved, held))
        return

    def told(found: Answer) -> None:
        rows = (
            *held,
            ("predicted change of cost", f"{found.cost_change:+,.1f}"),
            ("largest move of a pose", f"{1000 * found.largest_move:.1f} mm"),
        )
        tell(Preview(rows, ghost_of(state.amended.snapshot, found.decisions), None, found.at_rest))

    last = answer(state.footing, decisions, told)
    told(replace(last, at_rest=True))


def _bent(state: Made, poses: Float[np.ndarray, "n 3"], held: list[tuple[str, str]]) -> Preview:
    """What a loop closure that moves the whole map would do, by the pose graph alone."""
    decisions = state.footing.ground.decisions
    moves = se2.compose(poses, se2.inverse(decisions.poses))
    splines = tuple(
        replace(
            spline,
            curve=spline.curve.with_control_points(carried(spline.curve.control_points, decisions.poses[:, :2], moves)),
        )
        for spline in decisions.splines
    )
    away = float(np.linalg.norm((poses - decisions.poses)[:, :2], axis=1).max())
    rows = (*held, ("largest move of a pose", f"{away:.2f} m"), ("then", "the map is built anew and adjusted"))
    after = replace(decisions, poses=poses, splines=SplineMap(splines))
    return Preview(rows, ghost_of(state.amended.snapshot, after), None, True)


def distances(edit: Edit, decisions: Decisions, config: SlamConfig) -> list[tuple[str, str]]:
    """How far a piece lies from the spline that it is to be given to, and how much of it lies beside that."""
    if not isinstance(edit, Force) or edit.spline not in decisions.splines:
        return [("beams", str(len(decisions.points(edit))))] if isinstance(edit, OnPiece | MakeNew) else []
    spline, points = decisions.splines[edit.spline], decisions.points(edit)
    off = across(spline, points)
    t = spline.curve.foot_points(points)
    low, high = spline.span
    beside = (t > low + 1e-6) & (t < high - 1e-6)
    gate = config.association.gate
    rms = float(np.sqrt(np.mean(np.square(off[beside])))) if beside.any() else float("nan")
    distance = f"{1000 * rms:.0f} mm (gate {1000 * gate:.0f} mm)" if beside.any() else "it lies beyond its end"
    return [("distance", distance), ("overlap", f"{beside.mean():.0%} of {len(points)} beams")]


def held_apart(edit: Edit, among: tuple[Edit, ...], decisions: Decisions, config: SlamConfig) -> list[tuple[str, str]]:
    """Distances, named by the segment where several edits are proposed."""
    segment = f"segment {edit.segment}, " if len(among) > 1 and isinstance(edit, OnPiece) else ""
    return [(segment + name, value) for name, value in distances(edit, decisions, config)]


def ghost_of(before: Snapshot, decisions: Decisions) -> Ghost:
    """What looks different from a result: poses and splines that moved, splines that came, were drawn anew or left."""
    now = {spline.id: spline.curve.control_points for spline in before.map}
    different = tuple(
        spline
        for spline in decisions.splines
        if (old := now.get(spline.id)) is None
        or old.shape != spline.curve.control_points.shape
        or np.abs(old - spline.curve.control_points).max() > MOVED
    )
    poses = poses_at(before, decisions)
    moved = np.linalg.norm((poses - before.poses)[:, :2], axis=1).max(initial=0.0) > MOVED
    gone = tuple(number for number in now if number not in decisions.splines)
    return Ghost(poses if moved else None, SplineMap(different), gone)


# -- results -------------------------------------------------------------------------------------------------------
def made_message(job: int, base: Snapshot, state: Solved, seconds: float) -> EditsMade:
    """The result with edits as the page gets it."""
    after = state.amended.snapshot
    changed = {
        new.scan: new.associations
        for old, new in zip(base.observations, after.observations, strict=True)
        if new is not old
    }
    return EditsMade(job, for_looking_at(after), changed, state.explanation, solution(base, state, seconds))


def solution(base: Snapshot, state: Solved, seconds: float) -> Solution | None:
    """The figures of the solve behind a result with edits."""
    estimate, told = state.amended.snapshot.estimate, state.explanation
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
