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

SILENCE = 0.5
"""Seconds after which progress is told of a key scan that leaves no record."""


def between_records(key_scans: int) -> int:
    """Every how many key scans leave a record."""
    return -(-key_scans // RECORDS)


def records_of(key_scans: int) -> int:
    """How many records a pass over that many key scans leaves, that of the start included."""
    return 1 + -(-key_scans // between_records(key_scans))


class Watch:
    """Makes the records of one pass. Costs are ½Σρ of the whole graph, the key scans to come carried along.

    Progress is also told, with the number of the record to come, where key scans take long.
    """

    def __init__(self, graph: Graph, curves: CurveTerms, edges: EdgeTerms, progress: Progress) -> None:
        self._graph, self._curves, self._edges, self._progress = graph, curves, edges, progress
        self._began = self._told = perf_counter()
        self._every = between_records(len(graph.poses))
        self.records: list[IterationRecord] = []
        self.add(State(graph.poses, graph.control_points))
        if not np.isfinite(self.records[0].cost):
            raise SolverError("the problem holds values that are not finite numbers")

    def note(self, poses: Float[np.ndarray, "k 3"], control_points: Float[np.ndarray, "N 2"]) -> None:
        """After the k-th key scan."""
        leaves_record = len(poses) % self._every == 0 or len(poses) == len(self._graph.poses)
        if leaves_record or perf_counter() - self._told > SILENCE:
            record = self._record(State(carried_on(self._graph, poses), control_points))
            self._tell(record, keep=leaves_record)

    def add(self, state: State) -> None:
        """One more, at this state."""
        self._tell(self._record(state), keep=True)

    def _record(self, state: State) -> IterationRecord:
        cost = 0.5 * (self._curves.cost(state.poses, state.control_points) + self._edges.cost(state.poses)[0])
        before = self.records[-1] if self.records else None
        turned = np.zeros_like(state.poses) if before is None else state.poses - before.poses
        turned[:, 2] = se2.wrap(turned[:, 2])
        moved = state.control_points - (state.control_points if before is None else before.control_points)
        largest = float(np.linalg.norm(turned[:, :2], axis=1).max(initial=0.0))
        norm, seconds = State(turned, moved).norm, perf_counter() - self._began
        index = len(self.records)
        return IterationRecord(index, cost, norm, largest, seconds, state.poses.copy(), state.control_points.copy())

    def _tell(self, record: IterationRecord, *, keep: bool) -> None:
        if keep:
            self.records.append(record)
        self._progress(record)
        self._told = perf_counter()
