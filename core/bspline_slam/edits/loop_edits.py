"""Edits of what ties poses to each other: loop closures made and dropped, poses pinned; and the map that follows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.adjustment.adjust import adjust_splines
from bspline_slam.backends import Stopping, back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, never
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, DropLoop, PinPose
from bspline_slam.errors import Cancelled, EditError
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.front_end.mapping import MapBuilder
from bspline_slam.graph import Graph, PoseFactor, PosePrior
from bspline_slam.models.protocol import Model
from bspline_slam.slam import SlamConfig, StageProgress, quiet
from bspline_slam.tidying.tidy_map import tidied

BY_HAND = "closed by hand"
RELAXED = Stopping(1e-5, 1e-4, 20)


def close_loop(decisions: Decisions, edit: CloseLoop, config: SlamConfig) -> Decisions:
    """One more loop closure, with the same robust kernel as all others."""
    i, j = decisions.number(edit.earlier), decisions.number(edit.scan)
    if i == j:
        raise EditError(f"scan {edit.scan} cannot be tied to itself")
    measured, root = np.array(edit.measured), np.array(edit.sqrt_information)
    factor = PoseFactor(i, j, measured, root, "loop", config.loops.kernel)
    covariance = np.linalg.inv(root.T @ root)
    closure = LoopClosure(
        edit.earlier, edit.scan, measured, covariance, edit.score, edit.inliers, accepted=True, reason=BY_HAND
    )
    return replace(decisions, factors=(*decisions.factors, factor), closures=(*decisions.closures, closure))


def drop_loop(decisions: Decisions, edit: DropLoop) -> Decisions:
    """The closures between two key scans not believed."""
    pair = {decisions.number(edit.earlier), decisions.number(edit.scan)}
    kept = tuple(f for f in decisions.factors if f.kind != "loop" or {f.i, f.j} != pair)
    if len(kept) == len(decisions.factors):
        raise EditError(f"no loop closure ties scan {edit.scan} to scan {edit.earlier}")
    return replace(decisions, factors=kept, closures=tuple(_dropped(c, edit) for c in decisions.closures))


def _dropped(closure: LoopClosure, edit: DropLoop) -> LoopClosure:
    meant = closure.accepted and {closure.earlier, closure.scan} == {edit.earlier, edit.scan}
    return replace(closure, accepted=False, reason="dropped by hand") if meant else closure


def pin_pose(decisions: Decisions, edit: PinPose) -> Decisions:
    """The pose held where the edit says."""
    return replace(decisions, pose_pins={**decisions.pose_pins, decisions.number(edit.scan): edit.pose})


def pins(decisions: Decisions, sigma: float) -> tuple[PosePrior, ...]:
    """The priors that hold pinned poses, with this standard deviation (m, rad)."""
    return tuple(PosePrior(k, np.array(pose), np.eye(3) / sigma) for k, pose in sorted(decisions.pose_pins.items()))


def moved_poses(before: Decisions, after: Decisions, config: SlamConfig) -> Float[np.ndarray, "n 3"] | None:
    """The key poses carried along with what changed ties do to the pose graph; None where this bends nothing by more
    than `rebuild_move`."""
    anchor = config.adjustment.anchor
    old = _relaxed(before.poses, before.factors, (), anchor)
    new = _relaxed(old, tuple(map(_trusted, after.factors, _fresh(before, after))), pins(after, anchor), anchor)
    if max(_bent(before.factors, old, new), _bent(after.factors, old, new)) <= config.rebuild_move:
        return None
    return se2.compose(se2.compose(new, se2.inverse(old)), before.poses)


def _fresh(before: Decisions, after: Decisions) -> list[bool]:
    """Which factors afterwards are new."""
    known = set(map(id, before.factors))
    return [id(factor) not in known for factor in after.factors]


def _trusted(factor: PoseFactor, fresh: bool) -> PoseFactor:
    """A new closure as if it were right: whether the others outvote it shows once the map is where it says."""
    return replace(factor, kernel=None) if fresh else factor


def _relaxed(
    poses: Float[np.ndarray, "n 3"], factors: tuple[PoseFactor, ...], priors: tuple[PosePrior, ...], anchor: float
) -> Float[np.ndarray, "n 3"]:
    """The pose graph solved."""
    graph = Graph(
        key_scans=np.arange(len(poses)),
        poses=poses,
        spline_ids=np.zeros(0, dtype=np.int64),
        spline_first=np.zeros(1, dtype=np.int64),
        control_points=np.zeros((0, 2)),
        pose_factors=factors,
        pose_priors=(PosePrior(0, poses[0], np.eye(3) / anchor), *priors),
    )
    return back_end("pose_graph", RELAXED).solve(graph).poses


def _bent(factors: Sequence[PoseFactor], old: Float[np.ndarray, "n 3"], new: Float[np.ndarray, "n 3"]) -> float:
    """By how much (m) poses differ most, each seen from those that it is tied to."""
    i, j = (np.array([getattr(factor, end) for factor in factors], dtype=np.int64) for end in "ij")
    off = se2.between(se2.between(old[i], old[j]), se2.between(new[i], new[j]))
    return float(np.hypot(off[:, 0], off[:, 1]).max(initial=0.0))


def rebuilt(
    decisions: Decisions,
    lost: Sequence[bool],
    config: SlamConfig,
    model: Model,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
) -> tuple[Decisions, Estimate]:
    """The map built anew at the poses and adjusted; splines keep the ids of those that the same segments began."""
    builder = MapBuilder(config.association, model, _inheritance(decisions), first_id=_next_id(decisions))
    keys = []
    for key, pose, blind in zip(decisions.keys, decisions.poses, lost, strict=True):
        if cancelled():
            raise Cancelled("cancelled while the map was built anew")
        progress("rebuild", len(keys) / len(decisions.keys), None)
        seen = () if blind else builder.add(key.scan, pose, key.segments, key.sensor)
        keys.append(replace(key, associations=seen))
    named = tuple(
        replace(key, associations=tuple(replace(a, spline=_heir(builder, a.spline)) for a in key.associations))
        for key in keys
    )
    least = min(config.least_observations, len(keys))
    worthy = builder.map.seen_by_at_least(least)
    named, tidy = tidied(named, decisions.poses, worthy, config.merging, config.adjustment, model)
    splines, estimate = adjust_splines(
        named, decisions.poses, tidy.seen_by_at_least(least), decisions.factors, config.adjustment, model, "direct",
        lambda fraction, record: progress("adjustment", fraction, record), cancelled,
    )  # fmt: skip
    return replace(decisions, poses=estimate.poses, keys=named, splines=splines), estimate


def _heir(builder: MapBuilder, spline: int | None) -> int | None:
    return None if spline is None else builder.heir(spline)


def _inheritance(decisions: Decisions) -> Callable[[int, int], int]:
    """Which spline a segment belonged to: that which it begins when it is read anew takes this id again."""
    inherited: dict[tuple[int, int], int] = {}
    for key in decisions.keys:
        for association in key.associations:
            if association.spline is not None:
                inherited.setdefault((key.scan, association.segment), association.spline)
    return lambda scan, segment: inherited.get((scan, segment), -1)


def _next_id(decisions: Decisions) -> int:
    named = (a.spline for key in decisions.keys for a in key.associations if a.spline is not None)
    return max((*named, *(spline.id for spline in decisions.splines)), default=-1) + 1
