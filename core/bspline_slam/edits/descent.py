"""The way to an optimum nearby by one Cholesky factor for all steps, each a gradient and two triangular solves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import ROUNDING, Descent, State, Stopping, descend
from bspline_slam.backends.packing import CurveTerms, EdgeTerms, pack_curves, pack_edges
from bspline_slam.backends.pattern import gradient_of
from bspline_slam.backends.protocol import Cancelling, IterationRecord, silent
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.errors import Cancelled
from bspline_slam.graph import Graph

FALLING = 0.4
"""Each step is shorter than this share of the one before, or the factor is too old for the way."""
FACTORS = 5
"""So many factors are tried before each step gets one of its own."""


@dataclass(frozen=True, eq=False, slots=True)
class Packed:
    """The terms of a problem, whose pattern need not be known."""

    curves: CurveTerms
    edges: EdgeTerms

    @classmethod
    def of(cls, graph: Graph) -> Packed:
        """Those of a graph."""
        return cls(pack_curves(graph), pack_edges(graph))

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²)."""
        return 0.5 * (self.curves.cost(state.poses, state.control_points) + self.edges.cost(state.poses)[0])

    def gradient(self, state: State) -> State:
        """The gradient of the cost."""
        return gradient_of(self.curves, self.edges, state)

    def analysed(self, state: State) -> FullProblem:
        """The same with its pattern over the unknowns of a state."""
        return FullProblem.of(self.curves, self.edges, state)


def descended(
    problem: Packed, factor: Factor | None, start: State, stopping: Stopping, cancelled: Cancelling
) -> tuple[Descent, Factor]:
    """The optimum near `start` by `factor`, about that of Newton's matrix, and the factor of the last step. Where there
    is none, or steps no longer fall fast, it is made where the way has led; where that does not help, each of Newton's
    steps has its own. Raises SolverError, Cancelled."""
    state, cost = start, problem.cost(start)
    first = IterationRecord(0, cost, 0.0, 0.0, 0.0, start.poses, start.control_points)
    for _ in range(FACTORS):
        factor = factor or problem.analysed(state).linearise(state).newton()
        end, converged = _glided(problem, factor, state, stopping, cancelled)
        after = problem.cost(end)
        if after > cost + ROUNDING * (1.0 + cost):
            break
        state, cost = end, after
        if converged:
            return Descent(state, (first, _record(start, state, cost)), True), factor
        factor = None
    full = problem.analysed(state)
    found = descend(full, state, stopping, silent, cancelled)
    return found, full.linearise(found.state).newton()


def _glided(
    problem: Packed, factor: Factor, state: State, stopping: Stopping, cancelled: Cancelling
) -> tuple[State, bool]:
    """Where steps by this factor lead while they fall fast, and whether they come to rest there."""
    before = np.inf
    for index in range(1, stopping.iterations + 1):
        if cancelled():
            raise Cancelled(f"the optimisation was cancelled after {index - 1} iterations")
        step = factor.step(problem.gradient(state))
        if not step.largest < FALLING * before:
            break
        state, before = state.moved(step), step.largest
        if step.largest <= stopping.move:
            return state, True
    return state, False


def _record(start: State, end: State, cost: float) -> IterationRecord:
    """The way as one iteration."""
    way = State(end.poses - start.poses, end.control_points - start.control_points)
    farthest = float(np.linalg.norm(way.poses[:, :2], axis=1).max(initial=0.0))
    return IterationRecord(1, cost, way.norm, farthest, 0.0, end.poses, end.control_points)
