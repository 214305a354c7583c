"""I-DMJ: iterated joining on relative feature information (Huang et al. 2009), on splines.

Each local map says two things: how its features lie to each other, whatever the pose they were seen from, and where
its poses lie to those features. The map is made of the first alone: the pose of every key scan is a nuisance to be
eliminated, and neither odometry nor scan matching nor loop closures have a say. Least squares is iterated on that;
then the poses are found in the map that came out, by everything that speaks of them.

What that promises, and what not:
* Without pose factors nothing is lost by the split. The poses that the elimination leaves are the best ones given the
  map, so map and poses are those of `direct`, and so are the covariances.
* With pose factors the optimum is another one: what they say of the map is ignored, as I-DMJ means it. Its map has
  less information, never more, and is the same whatever the pose factors say.
* Where features leave open how parts of the map lie to each other, they stay as they started.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import Descent, Linearised, State, Stopping, descend
from bspline_slam.backends.marginals import spline_covariance
from bspline_slam.backends.packing import CurveTerms, EdgeTerms, pack_curves, pack_edges
from bspline_slam.backends.pattern import Blocks, Pattern, find_pattern, linearise_terms
from bspline_slam.backends.protocol import (
    Cancelling,
    Estimate,
    IterationRecord,
    Marginals,
    Progress,
    never,
    silent,
    unless_cancelled,
)
from bspline_slam.backends.sparse_cholesky import Analysis, Factor
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.errors import Cancelled
from bspline_slam.graph import Graph

HOLD = 1e-2
"""Information (per m² or rad²) that holds each step, so that rounding moves nothing along what features leave open."""


PATIENT = Stopping(iterations=1000)
"""Some parts of a map hang together by little else than odometry; without it their steps shrink slowly."""


class Idmj:
    """Least squares on relative feature information, then the poses in that map.

    Costs of the iterations are those of the relative feature information, the prior of the map's frame included. The
    last record has the poses found in the map. χ² and its degrees of freedom are of the whole graph.
    """

    name = "idmj"

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or PATIENT

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The optimum of the map. Raises SolverError where a pose or spline hangs on nothing, and Cancelled."""
        check_anchored(graph)
        start = State(graph.poses, graph.control_points)
        relative = HeldProblem(FullProblem.from_graph(features_alone(graph)))
        mapped = descend(relative, start, self.stopping, progress, cancelled)
        if cancelled():
            raise Cancelled(f"the optimisation was cancelled after {len(mapped.records) - 1} iterations")
        curves, edges, points = pack_curves(graph), pack_edges(graph), mapped.state.control_points
        located = descend(
            PosesInMap.from_terms(curves, edges, points), poses_of(mapped.state), self.stopping, silent, cancelled
        )
        state = State(located.state.poses, points)
        records = (*mapped.records, _last(mapped.records[-1], mapped.state, state))
        progress(records[-1])
        return estimate_of(graph, curves, edges, Descent(state, records, mapped.converged and located.converged))

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Of splines: blocks of the inverse of the relative feature information.

        Of poses: the covariance given the map, and that of the map carried through the poses' sensitivity to it. That
        the same beams made the map and located the poses in it is accounted for where there are no pose factors.
        """
        graph, state = estimate.graph, State(estimate.poses, estimate.control_points)
        problem = FullProblem.from_graph(features_alone(graph), whole_splines=True)
        factor = problem.linearise(state).factorise()
        _, curve_blocks = factor.inverse_blocks()
        located = PosesInMap.from_terms(pack_curves(graph), pack_edges(graph), estimate.control_points)
        return Marginals(
            {pose: located.covariance(pose, state.poses, factor) for pose in unless_cancelled(cancelled, poses)},
            {spline: spline_covariance(curve_blocks, graph, spline) for spline in splines},
        )


def features_alone(graph: Graph) -> Graph:
    """The graph without its pose factors: each pose is tied to the map by what was seen from it, to nothing else."""
    return replace(graph, pose_factors=())


def poses_of(state: State) -> State:
    """The poses without control points."""
    return State(state.poses, np.empty((0, 2)))


def _last(before: IterationRecord, old: State, new: State) -> IterationRecord:
    step = State(new.poses - old.poses, np.empty((0, 2)))
    move = float(np.linalg.norm(step.poses[:, :2], axis=1).max(initial=0.0))
    return IterationRecord(
        before.index + 1, before.cost, step.norm, move, before.seconds, new.poses, new.control_points
    )


@dataclass(frozen=True, eq=False, slots=True)
class HeldProblem:
    """A problem whose steps are held by HOLD: what nothing observes stays, and no optimum moves."""

    problem: FullProblem

    def cost(self, state: State) -> float:
        return self.problem.cost(state)

    def linearise(self, state: State) -> HeldLinearised:
        return HeldLinearised(self.problem.linearise(state))


@dataclass(frozen=True, eq=False, slots=True)
class HeldLinearised:
    """Its linear system at one state."""

    linearised: Linearised

    def step(self, damping: float) -> State:
        return self.linearised.step(damping + HOLD)


@dataclass(frozen=True, eq=False, slots=True)
class PosesInMap:
    """All terms that speak of poses, the control points taken as given."""

    curves: CurveTerms
    edges: EdgeTerms
    control_points: Float[np.ndarray, "N 2"]
    pattern: Pattern

    @classmethod
    def from_terms(cls, curves: CurveTerms, edges: EdgeTerms, control_points: Float[np.ndarray, "N 2"]) -> PosesInMap:
        return cls(curves, edges, control_points, find_pattern(curves, edges, len(control_points)))

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²) at these poses."""
        return 0.5 * (self.curves.cost(state.poses, self.control_points) + self.edges.cost(state.poses)[0])

    def linearise(self, state: State) -> LocatedPoses:
        blocks = linearise_terms(self.curves, self.edges, self.pattern, State(state.poses, self.control_points))
        return LocatedPoses(self.pattern, blocks)

    def covariance(self, pose: int, poses: Float[np.ndarray, "n 3"], relative: Factor) -> Float[np.ndarray, "3 3"]:
        """H_pp⁻¹ + S Σ Sᵀ of one pose, S = −H_pp⁻¹ H_pc, Σ the covariance of the map by its own information."""
        n, count = len(poses), len(self.control_points)
        located = self.linearise(State(poses, np.empty((0, 2))))
        unit = np.zeros((3 * n, 3))
        unit[3 * pose : 3 * pose + 3] = np.eye(3)
        given_map = located.factorise(0.0).solve(unit)
        by_point = np.zeros((count, 2, 3))
        points, observers = self.pattern.sights.T
        np.add.at(by_point, points, located.blocks.sight @ given_map.reshape(n, 3, 3)[observers])
        sensitivity = np.concatenate([np.zeros((3 * n, 3)), -by_point.reshape(2 * count, 3)])
        return given_map[3 * pose : 3 * pose + 3] + sensitivity.T @ relative.solve(sensitivity)


@dataclass(frozen=True, eq=False, slots=True)
class LocatedPoses:
    """The linear system of the poses at one state."""

    pattern: Pattern
    blocks: Blocks

    def step(self, damping: float) -> State:
        return self.factorise(damping).step(poses_of(self.blocks.gradient))

    def factorise(self, damping: float) -> Factor:
        """The factor of the poses' own matrix."""
        none = np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 1), dtype=bool)
        pattern = Pattern(self.pattern.edges, self.pattern.edge_slot, *none)
        blocks = replace(
            self.blocks,
            sight=np.zeros((0, 2, 3)),
            bent_sight=np.zeros((0, 2, 3)),
            curve=np.zeros((0, 1, 2, 2)),
            gradient=poses_of(self.blocks.gradient),
        )
        return Analysis.from_pattern(pattern, len(blocks.pose)).factorise(blocks, damping)
