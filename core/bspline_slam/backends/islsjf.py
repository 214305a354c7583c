"""I-SLSJF: local maps joined one after another, all of them linearised again wherever the state moves.

After Huang et al. 2008. Each local map is one observation of the joint state, and joining adds its information to the
sum. New states start where their map puts them, from the estimate of its frame. While a step moves the state by more
than 1 cm or 0.01 rad, all maps joined so far are linearised again at the new estimate and summed again, at most 10
times: Gauss-Newton on local maps. Its steps are not damped, for the way to the optimum of a long chain leads uphill:
the first one bends it and stretches it, the next ones take the stretching back.

The published filter refactors its matrix with every map, nearby states last so that little of it changes. Here maps
are summed in groups that double the joint map and factorised in minimum-degree order: all the solving then costs
about twice the last one, which is less than any update of the factor map by map. A group that does not settle or
does not fit is taken back and joined in smaller ones, down to single maps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool

from bspline_slam import se2
from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.direct import Direct
from bspline_slam.backends.gauss_newton import Descent, State, Stopping, descend
from bspline_slam.backends.graph_maps import local_maps_of
from bspline_slam.backends.local_maps import WORLD, LocalMaps
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, Marginals, Progress, never, silent
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.graph import Graph

MOVED = Stopping(decrease=1.0, move=0.01, iterations=10)
"""While joining: linearised again when the state moves by more than 0.01, at most 10 times."""
MISFIT = 2.0
"""A group does not fit when it multiplies χ² per residual by this and adds as much."""
PATIENCE = 20
"""Groups taken back before the maps are believed to contradict each other; then misfits are left to the descent."""


class Islsjf:
    """The iterated sparse local submap joining filter on a graph: one local map per key scan.

    A key scan's map holds what its beams say of control points, in its own frame and in information form, for they
    leave directions open; and its relative pose to those before it. Nothing is lost and nothing added, and all maps
    are linearised again until nothing moves: the optimum is that of `direct`.
    """

    name = "islsjf"

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or Stopping()

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The optimum of the graph. Raises SolverError where a pose or spline hangs on nothing, and Cancelled."""
        check_anchored(graph)
        maps = local_maps_of(graph)
        start = State(graph.poses, graph.control_points)
        descent = join(maps, start, self.stopping, progress, cancelled)
        return estimate_of(graph, pack_curves(graph), pack_edges(graph), descent)

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Blocks of the inverse of the joint information, which is the Gauss-Newton matrix of `direct`."""
        return Direct().covariances(estimate, poses=poses, splines=splines, cancelled=cancelled)


def join(
    maps: LocalMaps, start: State, stopping: Stopping, progress: Progress = silent, cancelled: Cancelling = never
) -> Descent:
    """Join all maps, then lower the cost of all of them until it converges. Raises Cancelled.

    Record 0 is `start`; where joining found a cheaper state, record 1 is that one. Of a start that is cheaper
    than what joining finds, nothing is thrown away: the descent begins there.
    """
    first = IterationRecord(0, maps.cost(start), 0.0, 0.0, 0.0, start.poses, start.control_points)
    progress(first)
    joined = join_in_order(maps, start, cancelled)
    if maps.cost(joined) >= first.cost:
        joined = start
    records = [first]

    def note(record: IterationRecord) -> None:
        if record.index > 0 or joined is not start:
            records.append(replace(record, index=len(records)))
            progress(records[-1])

    descent = descend(maps, joined, stopping, note, cancelled)
    return replace(descent, records=tuple(records))


def join_in_order(maps: LocalMaps, start: State, cancelled: Cancelling = never) -> State:
    """The state that joining in groups arrives at. `start` says how each map's states lie to each other at first."""
    state, placed = start, Placed.nothing(start)
    done, group, misfit, setbacks = 0, 1, 0.0, 0

    def check() -> None:
        if cancelled():
            raise Cancelled(f"the joining was cancelled after {done} of {len(maps)} local maps")

    while done < len(maps):
        count = min(done + group, len(maps))
        guess, now_placed = placed_by(maps.part(done, count), start, state, placed)
        joined = maps.part(0, count)
        settled = settle(joined, guess, check)
        fits = settled is not None and misfit_of(joined, settled) <= MISFIT * (1.0 + misfit)
        if not fits and group > 1 and setbacks < PATIENCE:
            group, setbacks = group // 2, setbacks + 1
            continue
        state = settled if fits and settled is not None else descend(joined, guess, MOVED, silent, cancelled).state
        placed, misfit, done = now_placed, misfit_of(joined, state), count
        group = min(2 * group, done)
    return state


def settle(maps: LocalMaps, state: State, check: Callable[[], None]) -> State | None:
    """Where undamped Gauss-Newton steps come to rest; None where they do not, or the maps leave something open."""
    for _ in range(MOVED.iterations):
        check()
        try:
            step = maps.linearise(state).step(0.0)
        except SolverError:
            return None
        state = state.moved(step)
        if step.largest <= MOVED.move:
            return state
    return None


def misfit_of(maps: LocalMaps, state: State) -> float:
    """χ² per residual."""
    return 2.0 * maps.cost(state) / len(maps.b)


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Which poses and points have their place in the joint map, and the pose placed last (WORLD: none)."""

    poses: Bool[np.ndarray, "n"]
    points: Bool[np.ndarray, "N"]
    last: int

    @classmethod
    def nothing(cls, state: State) -> Placed:
        return cls(np.zeros(len(state.poses), dtype=bool), np.zeros(len(state.control_points), dtype=bool), WORLD)


def placed_by(maps: LocalMaps, start: State, state: State, placed: Placed) -> tuple[State, Placed]:
    """The state with the new states of these maps where `start` has them, seen from the frame of their map."""
    to_now = np.vstack([se2.compose(state.poses, se2.inverse(start.poses)), se2.IDENTITY])
    known_poses, points, known_points = np.append(placed.poses, True), state.control_points.copy(), placed.points.copy()
    last = placed.last

    def settle(pose: int, frame: int) -> None:
        nonlocal last
        if not known_poses[pose]:
            to_now[pose], known_poses[pose], last = to_now[frame], True, pose

    for k in range(len(maps)):
        (a, b), (c, d) = maps.begin[k : k + 2, 0], maps.begin[k : k + 2, 1]
        for frame in (*maps.pose_frame[a:b], *maps.point_frame[c:d]):
            settle(int(frame), last)
        for frame, pose in zip(maps.pose_frame[a:b], maps.pose[a:b], strict=True):
            settle(int(pose), int(frame))
        new = ~known_points[maps.point[c:d]]
        seen, frames = maps.point[c:d][new], maps.point_frame[c:d][new]
        points[seen] = se2.transform(to_now[frames], start.control_points[seen])
        known_points[seen] = True
    poses = np.where(known_poses[:-1, None], se2.compose(to_now[:-1], start.poses), state.poses)
    return State(poses, points), Placed(known_poses[:-1], known_points, last)
