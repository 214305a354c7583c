"""Records of back ends that go through the key scans once, in their order, instead of iterating over all of them."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.arrival import carried_on
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.packing import CurveTerms, EdgeTerms
from bspline_slam.backends.protocol import IterationRecord, Progress
from bspline_slam.errors import SolverError
from bspline_slam.graph import Graph

RECORDS = 100
"""Key scans that leave a record, at most; on longer logs only every n-th does."""


def between_records(key_scans: int) -> int:
    """Every how many key scans leave a record."""
    return -(-key_scans // RECORDS)


def records_of(key_scans: int) -> int:
    """How many records a pass over that many key scans leaves, that of the start included."""
    return 1 + -(-key_scans // between_records(key_scans))


class Watch:
    """Makes the records of one pass. Costs are ½Σρ of the whole graph, the key scans to come carried along."""

    def __init__(self, graph: Graph, curves: CurveTerms, edges: EdgeTerms, progress: Progress) -> None:
        self._graph, self._curves, self._edges, self._progress = graph, curves, edges, progress
        self._began = perf_counter()
        self._every = between_records(len(graph.poses))
        self.records: list[IterationRecord] = []
        self._add(State(graph.poses, graph.control_points))
        if not np.isfinite(self.records[0].cost):
            raise SolverError("the problem holds values that are not finite numbers")

    def note(self, poses: Float[np.ndarray, "k 3"], control_points: Float[np.ndarray, "N 2"]) -> None:
        """After the k-th key scan."""
        if len(poses) % self._every == 0 or len(poses) == len(self._graph.poses):
            self._add(State(carried_on(self._graph, poses), control_points))

    def last(self, state: State) -> None:
        """One more, after the last key scan."""
        self._add(state)

    def _add(self, state: State) -> None:
        cost = 0.5 * (self._curves.cost(state.poses, state.control_points) + self._edges.cost(state.poses)[0])
        before = self.records[-1] if self.records else None
        turned = np.zeros_like(state.poses) if before is None else state.poses - before.poses
        turned[:, 2] = se2.wrap(turned[:, 2])
        moved = state.control_points - (state.control_points if before is None else before.control_points)
        largest = float(np.linalg.norm(turned[:, :2], axis=1).max(initial=0.0))
        norm, seconds = State(turned, moved).norm, perf_counter() - self._began
        index = len(self.records)
        self.records.append(
            IterationRecord(index, cost, norm, largest, seconds, state.poses.copy(), state.control_points.copy())
        )
        self._progress(self.records[-1])
