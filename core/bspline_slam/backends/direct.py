"""The default back end: compiled linearisation of the whole problem and one sparse factor of it per iteration.

Its steps are those of Newton: residuals of many beams on weakly held curves leave Gauss-Newton a contraction of about
0.7 per step, fifty steps to the optimum of a building; Newton takes five. Covariances are those of Gauss-Newton.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.gauss_newton import State, Stopping, descend
from bspline_slam.backends.marginals import spline_covariance
from bspline_slam.backends.packing import CurveTerms, EdgeTerms, pack_curves, pack_edges
from bspline_slam.backends.pattern import Blocks, Pattern, fill_splines, find_pattern, linearise_terms
from bspline_slam.backends.protocol import (
    Cancelling,
    Estimate,
    Marginals,
    Progress,
    never,
    silent,
    unless_cancelled,
)
from bspline_slam.backends.sparse_cholesky import Analysis, Factor
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.errors import SolverError
from bspline_slam.graph import Graph


@dataclass(frozen=True, eq=False, slots=True)
class FullProblem:
    """All terms of a graph over all its unknowns."""

    curves: CurveTerms
    edges: EdgeTerms
    pattern: Pattern
    analysis: Analysis

    @classmethod
    def from_graph(cls, graph: Graph, *, whole_splines: bool = False) -> FullProblem:
        """Pack the graph and analyse its pattern; with `whole_splines` the factor holds each spline in full."""
        curves, edges = pack_curves(graph), pack_edges(graph)
        pattern = find_pattern(curves, edges, len(graph.control_points))
        if whole_splines:
            pattern = fill_splines(pattern, graph.spline_first)
        return cls(curves, edges, pattern, Analysis.from_pattern(pattern, len(graph.poses)))

    @classmethod
    def of(cls, curves: CurveTerms, edges: EdgeTerms, state: State) -> FullProblem:
        """Analyse the pattern of terms over the unknowns of a state."""
        pattern = find_pattern(curves, edges, len(state.control_points))
        return cls(curves, edges, pattern, Analysis.from_pattern(pattern, len(state.poses)))

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²)."""
        return 0.5 * (self.curves.cost(state.poses, state.control_points) + self.edges.cost(state.poses)[0])

    def linearise(self, state: State) -> LinearisedBlocks:
        return LinearisedBlocks(self.analysis, linearise_terms(self.curves, self.edges, self.pattern, state))


@dataclass(frozen=True, eq=False, slots=True)
class LinearisedBlocks:
    """The linear system at one state."""

    analysis: Analysis
    blocks: Blocks

    def step(self, damping: float) -> State:
        """Newton's step where that leads downhill, else that of Gauss and Newton, which alone is damped."""
        factor = self.newton() if damping == 0.0 else self.factorise(damping)
        return factor.step(self.blocks.gradient)

    def newton(self) -> Factor:
        """Factor of Newton's matrix, or of that of Gauss and Newton where that is none of a minimum."""
        try:
            return self.analysis.factorise(self.blocks.newton())
        except SolverError:
            return self.factorise()

    def factorise(self, damping: float = 0.0) -> Factor:
        return self.analysis.factorise(self.blocks, damping)


class Direct:
    """Newton's method on poses and control points together."""

    name = "direct"

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or Stopping()

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The optimum of the graph. Raises SolverError where a pose or spline hangs on nothing, and Cancelled."""
        check_anchored(graph)
        problem = FullProblem.from_graph(graph)
        start = State(graph.poses, graph.control_points)
        descent = descend(problem, start, self.stopping, progress, cancelled)
        return estimate_of(graph, problem.curves, problem.edges, descent)

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Blocks of the inverse of the Gauss-Newton matrix at the estimate, robust weights as they are there."""
        problem = FullProblem.from_graph(estimate.graph, whole_splines=True)
        factor = problem.linearise(State(estimate.poses, estimate.control_points)).factorise()
        pose_blocks, curve_blocks = factor.inverse_blocks()
        return Marginals(
            {pose: pose_blocks[pose] for pose in poses},
            {
                spline: spline_covariance(curve_blocks, estimate.graph, spline)
                for spline in unless_cancelled(cancelled, splines)
            },
        )
