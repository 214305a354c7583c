"""Smoothing and mapping with gtsam: the same factors and the same optimum as `direct`, as a reference.

gtsam holds Python's lock while it eliminates: run this back end in a process of its own where anything else must
stay responsive. One iteration linearises, eliminates (multifrontal Cholesky, METIS order found once) and retracts by
hand: the optimiser classes evaluate the Python factors several times as often, and COLAMD fills in three times as
much. Keys are integers: pose i is i, control point k is n + k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import gtsam
import numpy as np

from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State, Stopping, descend
from bspline_slam.backends.marginals import control_points_of
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import (
    Cancelling,
    Estimate,
    Marginals,
    Progress,
    never,
    silent,
    unless_cancelled,
)
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.graph import Graph, Kernel, PoseFactor, PosePrior, ShapePrior, SplineFactor

Jacobians = gtsam.JacobianVector | None
"""The list to be filled, or None where only the error is wanted."""
Error = Callable[[gtsam.CustomFactor, gtsam.Values, Jacobians], np.ndarray]


class Sam:
    """Batch smoothing with gtsam.CustomFactor."""

    name = "sam"

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or Stopping()

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The optimum of the graph. Raises SolverError where a pose or spline hangs on nothing, and Cancelled."""
        check_anchored(graph)
        start = State(graph.poses, graph.control_points)
        descent = descend(FactorProblem(graph, cancelled), start, self.stopping, progress, cancelled)
        return estimate_of(graph, pack_curves(graph), pack_edges(graph), descent)

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Blocks of the inverse of the Gauss-Newton matrix at the estimate, asked of gtsam's Bayes tree one by one.

        On a map of 1,000 poses each block takes gtsam about 0.1 to 0.5 s; `direct` gives the same numbers all at once.
        """
        graph, state = estimate.graph, State(estimate.poses, estimate.control_points)
        linearised = FactorProblem(graph).linearise(state)
        tree = linearised.held(0.0).eliminateMultifrontal(linearised.ordering)
        keys = {spline: (len(graph.poses) + control_points_of(graph, spline)).tolist() for spline in splines}
        return Marginals(
            {pose: tree.marginalCovariance(pose) for pose in unless_cancelled(cancelled, poses)},
            {
                spline: tree.jointMarginalCovariance(keys[spline]).fullMatrix()
                for spline in unless_cancelled(cancelled, splines)
            },
        )


class FactorProblem:
    """A graph as gtsam factors, and the order in which their keys are eliminated."""

    def __init__(self, graph: Graph, cancelled: Cancelling = never) -> None:
        n, self.factors = len(graph.poses), factors_of(graph, cancelled)
        self.ordering = gtsam.Ordering.MetisNonlinearFactorGraph(self.factors)
        touched = self.factors.keys()
        for key in range(n + len(graph.control_points)):
            if touched.count(key) == 0:
                self.ordering.push_back(key)

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²)."""
        return self.factors.error(values_of(state))

    def linearise(self, state: State) -> LinearisedFactors:
        return LinearisedFactors(self.factors.linearize(values_of(state)), state, self.ordering)


@dataclass(frozen=True, eq=False, slots=True)
class LinearisedFactors:
    """The linear factors at one state."""

    factors: gtsam.GaussianFactorGraph
    at: State
    ordering: gtsam.Ordering

    def step(self, damping: float) -> State:
        try:
            solution = self.held(damping).optimize(self.ordering).vector()
        except RuntimeError as error:
            raise SolverError(f"gtsam cannot eliminate the problem: {str(error).strip()}") from error
        poses = 3 * len(self.at.poses)
        return State(solution[:poses].reshape(-1, 3), solution[poses:].reshape(-1, 2))

    def held(self, damping: float) -> gtsam.GaussianFactorGraph:
        """The linear factors, and one on each key that holds its step."""
        held, root = self.factors.clone(), np.sqrt(STEP_INFORMATION + damping)
        for key in range(len(self.at.poses) + len(self.at.control_points)):
            size = 3 if key < len(self.at.poses) else 2
            held.add(key, root * np.eye(size), np.zeros(size), gtsam.noiseModel.Unit.Create(size))
        return held


def factors_of(graph: Graph, cancelled: Cancelling = never) -> gtsam.NonlinearFactorGraph:
    """All factors of a graph in gtsam's hands. Evaluating one raises Cancelled when nobody waits any more."""
    factors, n = gtsam.NonlinearFactorGraph(), len(graph.poses)

    def add(rows: int, keys: list[int], error: Error, kernel: Kernel = None) -> None:
        model = gtsam.noiseModel.Unit.Create(rows)
        if kernel is not None:
            model = gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Cauchy.Create(kernel), model)
        factors.add(gtsam.CustomFactor(model, keys, unless_nobody_waits(error, cancelled)))

    for spline in graph.spline_factors:
        keys = [spline.pose, *range(n + spline.first, n + spline.first + spline.A.shape[1] // 2)]
        add(len(spline.b), keys, spline_error(spline, keys))
    for edge in graph.pose_factors:
        add(3, [edge.i, edge.j], edge_error(edge), edge.kernel)
    for prior in graph.pose_priors:
        add(3, [prior.pose], prior_error(prior))
    for shape in graph.shape_priors:
        keys = [*range(n + shape.first, n + shape.first + shape.A.shape[1] // 2)]
        add(len(shape.b), keys, shape_error(shape, keys))
    return factors


def values_of(state: State) -> gtsam.Values:
    """A state under its keys."""
    values = gtsam.Values()
    for key, unknown in enumerate([*state.poses, *state.control_points]):
        values.insert(key, unknown)
    return values


def unless_nobody_waits(error: Error, cancelled: Cancelling) -> Error:
    """The same error, but Cancelled once that is so: gtsam looks at nothing else for seconds."""

    def checked(factor: gtsam.CustomFactor, values: gtsam.Values, H: Jacobians) -> np.ndarray:
        if cancelled():
            raise Cancelled("the optimisation was cancelled within an iteration")
        return error(factor, values, H)

    return checked


def spline_error(factor: SplineFactor, keys: list[int]) -> Error:
    def error(_: gtsam.CustomFactor, values: gtsam.Values, H: Jacobians) -> np.ndarray:
        pose, points = values.atVector(keys[0]), np.array([values.atVector(key) for key in keys[1:]])
        if H is not None:
            by_pose, by_points = factor.jacobians(pose, points)
            H[0] = by_pose
            _fill_points(H, 1, by_points)
        return factor.residual(pose, points)

    return error


def edge_error(factor: PoseFactor) -> Error:
    def error(_: gtsam.CustomFactor, values: gtsam.Values, H: Jacobians) -> np.ndarray:
        pose_i, pose_j = values.atVector(factor.i), values.atVector(factor.j)
        if H is not None:
            H[0], H[1] = factor.jacobians(pose_i, pose_j)
        return factor.residual(pose_i, pose_j)

    return error


def prior_error(prior: PosePrior) -> Error:
    def error(_: gtsam.CustomFactor, values: gtsam.Values, H: Jacobians) -> np.ndarray:
        if H is not None:
            H[0] = prior.sqrt_information
        return prior.residual(values.atVector(prior.pose))

    return error


def shape_error(prior: ShapePrior, keys: list[int]) -> Error:
    def error(_: gtsam.CustomFactor, values: gtsam.Values, H: Jacobians) -> np.ndarray:
        points = np.array([values.atVector(key) for key in keys])
        if H is not None:
            _fill_points(H, 0, prior.A)
        return prior.residual(points)

    return error


def _fill_points(H: gtsam.JacobianVector, first: int, by_points: np.ndarray) -> None:
    """Hand over a Jacobian in pairs of columns, one pair per control point."""
    for k in range(by_points.shape[1] // 2):
        H[first + k] = by_points[:, 2 * k : 2 * k + 2]
