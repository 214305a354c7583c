"""Incremental smoothing with gtsam's ISAM2: the factors of `sam`, fed key scan by key scan.

Each key scan adds its factors to the Bayes tree, which eliminates anew only what they touch; every `EVERY` key scans
it linearises anew what has moved by more than `RELINEARISE`. After the last one a few updates without new factors let
the rest settle; poses and curves lie within a millimetre of the batch optimum (control points may slide along their
curve by a few, where the gauge alone holds them). Loop closures enter with their later pose.
Like `sam`, it holds Python's lock while gtsam eliminates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import gtsam
import numpy as np

from bspline_slam import se2
from bspline_slam.backends.arrival import Arrival, arrivals, first_seen, predicted_pose
from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.gauss_newton import STEP_INFORMATION, Descent, State, Stopping
from bspline_slam.backends.one_pass import Watch
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import Cancelling, Estimate, Marginals, Progress, never, silent
from bspline_slam.backends.sam import Sam, factors_of
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.graph import Graph

RELINEARISE = 1e-3
"""Move (m, rad) of an unknown beyond which its factors are linearised anew."""
EVERY = 10
"""Key scans from one look for such moves to the next: each is dear, for the factors are Python's."""
SETTLED = 1e-5
"""Largest move (m, rad) of an update after which nothing is left to settle."""
SETTLING = 10
"""Updates after the last key scan, at most."""


class Isam2:
    """Incremental smoothing; the starting values of poses count only where no factor predicts them."""

    name = "isam2"

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or Stopping()

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The smoothed estimate. Raises SolverError where a pose or spline hangs on nothing, and Cancelled."""
        check_anchored(graph)
        curves, edges = pack_curves(graph), pack_edges(graph)
        watch, smoother = Watch(graph, curves, edges, progress), Smoother(graph, cancelled)
        for arrival in arrivals(graph):
            if cancelled():
                raise Cancelled(f"the optimisation was cancelled after {arrival.pose} key scans")
            smoother.arrive(arrival)
            state = smoother.state(arrival.pose + 1)
            watch.note(state.poses, state.control_points)
        state, converged = smoother.settle()
        watch.add(state)
        return estimate_of(graph, curves, edges, Descent(state, tuple(watch.records), converged))

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Those of `sam` at the estimate: the Bayes tree of the whole graph, linearised there."""
        return Sam(self.stopping).covariances(estimate, poses=poses, splines=splines, cancelled=cancelled)


class Smoother:
    """The Bayes tree so far. Keys as in `sam`: pose i is i, control point k is n + k."""

    def __init__(self, graph: Graph, cancelled: Cancelling) -> None:
        self.graph, self.cancelled = graph, cancelled
        self.entered = np.zeros(len(graph.control_points), dtype=bool)
        parameters = gtsam.ISAM2Params()
        parameters.setOptimizationParams(gtsam.ISAM2GaussNewtonParams(SETTLED))
        parameters.setRelinearizeThreshold(RELINEARISE)
        parameters.relinearizeSkip = EVERY
        parameters.setFactorization("QR")
        self._tree = gtsam.ISAM2(parameters)

    def arrive(self, arrival: Arrival) -> None:
        """Add what one key scan brings. Raises SolverError where gtsam cannot eliminate it."""
        i, n = arrival.pose, len(self.graph.poses)
        pose = predicted_pose(self.graph, arrival, self._tree.calculateEstimateVector(i - 1) if i else None)
        entering = se2.transform(pose, first_seen(self.graph, arrival))
        factors = factors_of(
            replace(
                self.graph,
                spline_factors=arrival.spline_factors,
                pose_factors=arrival.pose_factors,
                pose_priors=arrival.pose_priors,
                shape_priors=arrival.shape_priors,
            ),
            self.cancelled,
        )
        values = gtsam.Values()
        for key, start in ((i, pose), *zip((n + arrival.control_points).tolist(), entering, strict=True)):
            values.insert(key, start)
            held = gtsam.noiseModel.Isotropic.Sigma(len(start), STEP_INFORMATION**-0.5)
            factors.add(gtsam.PriorFactorVector(key, start, held))
        self.entered[arrival.control_points] = True
        self._update(factors, values)

    def settle(self) -> tuple[State, bool]:
        """Update without new factors until nothing moves; whether that came to be. Raises Cancelled."""
        before = self.state(len(self.graph.poses))
        for _ in range(SETTLING):
            if self.cancelled():
                raise Cancelled("the optimisation was cancelled while the map settled")
            self._update(gtsam.NonlinearFactorGraph(), gtsam.Values(), relinearise=True)
            after = self.state(len(self.graph.poses))
            turned = after.poses - before.poses
            turned[:, 2] = se2.wrap(turned[:, 2])
            if State(turned, after.control_points - before.control_points).largest < SETTLED:
                return after, True
            before = after
        return before, False

    def state(self, count: int) -> State:
        """The first poses and all control points; those that have not entered are at their start."""
        values, n = self._tree.calculateEstimate(), len(self.graph.poses)
        poses = np.array([values.atVector(i) for i in range(count)])
        poses[:, 2] = se2.wrap(poses[:, 2])
        points = self.graph.control_points.copy()
        for k in np.flatnonzero(self.entered).tolist():
            points[k] = values.atVector(n + k)
        return State(poses, points)

    def _update(self, factors: gtsam.NonlinearFactorGraph, values: gtsam.Values, *, relinearise: bool = False) -> None:
        try:
            self._tree.update(factors, values, force_relinearize=relinearise)
        except RuntimeError as error:
            raise SolverError(f"gtsam cannot eliminate the problem: {str(error).strip()}") from error
