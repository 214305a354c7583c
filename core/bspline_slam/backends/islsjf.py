"""I-SLSJF: local maps joined one after another, all of them linearised again wherever the state moves.

After Huang et al. 2008. Each local map is one observation of the joint state, and joining adds its information to the
sum. New states start where their map puts them, from the estimate of its frame. While a step moves the state by more
than 1 cm or 0.01 rad, all maps joined so far are linearised again at the new estimate and summed again, at most 10
times: Gauss-Newton on local maps. Its steps are not damped, for the way to the optimum of a long chain leads uphill:
the first one bends it and stretches it, the next ones take the stretching back.

The published filter refactors its matrix with every map, nearby states last so that little of it changes. Here maps
are summed in groups that double the joint map and factorised in minimum-degree order: all the solving then costs
about twice the last one, which is less than any update of the factor map by map. A group that does not fit is taken
back and joined in smaller ones, down to single maps.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from jaxtyping import Bool

from bspline_slam import se2
from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.direct import Direct, FullProblem
from bspline_slam.backends.gauss_newton import Descent, Problem, State, Stopping, descend
from bspline_slam.backends.graph_maps import first_maps, local_maps_of
from bspline_slam.backends.local_maps import WORLD, LocalMaps
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, Marginals, Progress, never, silent
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.graph import Graph

LOG = logging.getLogger(__name__)
MOVED = Stopping(decrease=1.0, move=0.01, iterations=10)
"""While joining: linearised again when the state moves by more than 0.01, at most 10 times."""
MISFIT = 2.0
"""A group does not fit when it multiplies χ² per residual by this and adds as much."""
JOINING_RECORDS = 30
"""About how many records are told of with long logs; each is worth about the same time."""
PATIENCE = 20
"""Groups taken back before the maps are believed to contradict each other; then misfits are left to the descent."""

Joint = Callable[[int], Problem]
"""The first local maps, so many, summed into one problem."""


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
        maps, start = local_maps_of(graph), State(graph.poses, graph.control_points)

        def joint(count: int) -> FullProblem:
            return FullProblem.from_graph(first_maps(graph, count))

        descent = join(maps, joint, start, self.stopping, progress, cancelled)
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
    maps: LocalMaps,
    joint: Joint,
    start: State,
    stopping: Stopping,
    progress: Progress = silent,
    cancelled: Cancelling = never,
) -> Descent:
    """Join all maps, then lower the cost of all of them until it converges. Raises Cancelled.

    Record 0 of the descent is `start`; where joining found a cheaper state, record 1 is that one. Of a start that is
    cheaper than what joining finds, nothing is thrown away: the descent begins there. Progress is told of the joining
    as well (`JoinWatch`), which is no descent: its records are none of the descent's.
    """
    whole = joint(len(maps))
    watch = JoinWatch(maps, whole, start, progress, cancelled)
    joined = join_in_order(maps, joint, start, watch)
    if whole.cost(joined) >= watch.first.cost:
        joined = start
    records, began = [watch.first], watch.elapsed

    def note(record: IterationRecord) -> None:
        if record.index > 0 or joined is not start:
            records.append(replace(record, index=len(records), seconds=began + record.seconds))
            watch.tell(records[-1])

    descent = descend(whole, joined, stopping, note, cancelled)
    return replace(descent, records=tuple(records))


class JoinWatch:
    """Tells who waits for a joining where it is: a record each time that as many maps as there are have been linearised
    again, its cost that of all maps, those to come carried along by the last pose."""

    def __init__(
        self, maps: LocalMaps, whole: Problem, start: State, progress: Progress = silent, cancelled: Cancelling = never
    ) -> None:
        self._maps, self._whole, self._start = maps, whole, start
        self._progress, self.cancelled = progress, cancelled
        self._began = perf_counter()
        self._told = self._linearised = self._done = self._joined = 0
        self._placed = Placed.nothing(start)
        self.first = IterationRecord(0, whole.cost(start), 0.0, 0.0, 0.0, start.poses, start.control_points)
        self.tell(self.first)

    @property
    def elapsed(self) -> float:
        """Wall time (s) since the joining began."""
        return perf_counter() - self._began

    def begins(self, done: int, count: int, placed: Placed) -> None:
        """Now maps `done` … `count` − 1 are joined to those before, all their states being placed."""
        self._done, self._joined, self._placed = done, count, placed
        LOG.debug("joining local maps %d to %d of %d", done + 1, count, len(self._maps))

    def check(self) -> None:
        """Raises Cancelled when nobody waits any more."""
        if self.cancelled():
            raise Cancelled(f"the joining was cancelled after {self._done} of {len(self._maps)} local maps")

    def stepped(self, step: State, state: State) -> None:
        """The maps joined now have been linearised and the state moved."""
        self._linearised += self._joined
        if self._linearised < len(self._maps):
            return
        self._linearised = 0
        shown, _ = placed_by(self._maps.part(self._joined, len(self._maps)), self._start, state, self._placed)
        largest = float(np.linalg.norm(step.poses[:, :2], axis=1).max(initial=0.0))
        cost = self._whole.cost(shown)
        self.tell(IterationRecord(0, cost, step.norm, largest, self.elapsed, shown.poses, shown.control_points))

    def tell(self, record: IterationRecord) -> None:
        """Hand on a record, numbered as the next."""
        self._progress(replace(record, index=self._told))
        self._told += 1


def join_in_order(maps: LocalMaps, joint: Joint, start: State, watch: JoinWatch) -> State:
    """The state that joining in groups arrives at. `start` says how each map's states lie to each other at first.

    Raises Cancelled.
    """
    state, placed = start, Placed.nothing(start)
    done, group, misfit, setbacks = 0, 1, 0.0, 0
    while done < len(maps):
        count = min(done + group, len(maps))
        guess, now_placed = placed_by(maps.part(done, count), start, state, placed)
        watch.begins(done, count, now_placed)
        joined, residuals = joint(count), int(maps.begin[count, 3])
        settled = settle(joined, guess, watch)
        fits = settled is not None and misfit_of(joined, settled, residuals) <= MISFIT * (1.0 + misfit)
        if not fits and group > 1 and setbacks < PATIENCE:
            group, setbacks = group // 2, setbacks + 1
            continue
        if fits and settled is not None:
            state = settled
        else:
            state = descend(joined, guess, MOVED, silent, watch.cancelled).state
        placed, misfit, done = now_placed, misfit_of(joined, state, residuals), count
        group = min(2 * group, done)
    return state


def settle(joined: Problem, state: State, watch: JoinWatch) -> State | None:
    """Where undamped Gauss-Newton steps lead; None where the maps leave something open."""
    for _ in range(MOVED.iterations):
        watch.check()
        linearised = joined.linearise(state)
        watch.check()
        try:
            step = linearised.step(0.0)
        except SolverError:
            return None
        state = state.moved(step)
        watch.stepped(step, state)
        if step.largest <= MOVED.move:
            break
    return state


def misfit_of(joined: Problem, state: State, residuals: int) -> float:
    """χ² per residual."""
    return 2.0 * joined.cost(state) / residuals


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
