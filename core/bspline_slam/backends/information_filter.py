"""The filter behind `ekf` and `bs_slam`: an extended Kalman filter over the current pose and all control points.

It is kept in information form (Λ, the inverse of the covariance), which is the same estimator: motion is linearised
at the last estimate, observations at the prediction, each once and never again. Past poses stay in Λ, where they are
eliminated with every update: to marginalise them is the same, but would tie all control points to each other, and
that dense matrix of a large map cannot be factorised a thousand times. Nothing is linearised at them any more: the
estimate of a key scan is the filtered one of its own time, and pose factors between others than neighbours (loop
closures) are not stated. A loop closes when a spline is seen again.

A control point enters where the key scan that sees it first has it by the starting values, ±`NEWCOMER`: relative to
that pose, so it says nothing about the pose, and keeps within bounds what nothing observes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import SuperLU, splu

from bspline_slam import se2
from bspline_slam.backends.arrival import Arrival, arrivals, entries, first_seen, is_motion, predicted_pose
from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.gauss_newton import STEP_INFORMATION, Descent, State, Stopping
from bspline_slam.backends.marginals import control_points_of
from bspline_slam.backends.one_pass import Watch
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
from bspline_slam.graph import Graph, SplineFactor

NEWCOMER = 1.0
"""Standard deviation (m) of a control point that enters, relative to the pose that sees it first."""

Columns = Int[np.ndarray, "u"]
Entries = tuple[Columns, Columns, Float[np.ndarray, "u"]]


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """Whitened rows of one observation, linearised: residual, ∂/∂(x, y, θ) of the current pose, ∂/∂vec(c)."""

    control_points: Int[np.ndarray, "m"]
    residual: Float[np.ndarray, "r"]
    by_pose: Float[np.ndarray, "r 3"]
    by_points: Float[np.ndarray, "r d"]


Observe = Callable[[Arrival, Float[np.ndarray, "3"], Float[np.ndarray, "N 2"]], Sequence[Rows]]
"""What an arrival observes, linearised at its predicted pose and the control points."""


def spline_rows(factor: SplineFactor, pose: Float[np.ndarray, "3"], control_points: Float[np.ndarray, "N 2"]) -> Rows:
    """A spline factor, linearised."""
    seen = np.arange(factor.first, factor.first + factor.A.shape[1] // 2)
    by_pose, by_points = factor.jacobians(pose, control_points[seen])
    return Rows(seen, factor.residual(pose, control_points[seen]), by_pose, by_points)


class InformationFilter:
    """State of the filter: the means, Λ, and the poses filtered so far with their covariances."""

    def __init__(self, graph: Graph, observe: Observe) -> None:
        self.graph, self.observe = graph, observe
        self.coming = arrivals(graph)
        self.pose_slots, self.point_slots = slots(self.coming, len(graph.control_points))
        self.used = 0
        self.poses: list[np.ndarray] = []
        self.pose_covariances: list[np.ndarray] = []
        self.control_points = graph.control_points.copy()
        self.information = csc_array((graph.unknowns, graph.unknowns))

    def arrive(self, arrival: Arrival) -> None:
        """Predict, let control points enter, update."""
        pose = predicted_pose(self.graph, arrival, self.poses[-1] if self.poses else None)
        seen = first_seen(self.graph, arrival)
        self.control_points[arrival.control_points] = se2.transform(pose, seen)
        self.used += 3 + 2 * len(seen)
        now = self._pose_columns(arrival.pose)
        gradient = np.zeros(self.used)
        held: Entries = (now, now, np.full(3, STEP_INFORMATION))
        entries = [held]
        for columns, residual, jacobian in self._terms(arrival, pose, seen):
            gradient[columns] += jacobian.T @ residual
            count = len(columns)
            entries.append((np.repeat(columns, count), np.tile(columns, count), (jacobian.T @ jacobian).ravel()))
        rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        news = coo_array((values, (rows, columns)), shape=self.information.shape)
        self.information = csc_array(self.information + news.tocsc())
        self._update(now, pose, gradient)

    def spline_covariance(self, spline: int) -> Float[np.ndarray, "d d"]:
        """Of (c_1x, c_1y, c_2x, …) of the spline with this id."""
        columns = self._columns(control_points_of(self.graph, spline))
        return self._covariance(self._factor(), columns)

    def _terms(
        self, arrival: Arrival, pose: Float[np.ndarray, "3"], seen: Float[np.ndarray, "m 2"]
    ) -> Iterator[tuple[Columns, Float[np.ndarray, "r"], Float[np.ndarray, "r u"]]]:
        """Columns, residual and Jacobian of everything that an arrival brings."""
        now, points = self._pose_columns(arrival.pose), self.control_points
        around = {arrival.pose: pose, arrival.pose - 1: self.poses[-1] if self.poses else pose}
        for factor in arrival.pose_factors:
            ends = around[factor.i], around[factor.j]
            columns = np.append(self._pose_columns(factor.i), self._pose_columns(factor.j))
            yield columns, factor.residual(*ends), np.hstack(factor.jacobians(*ends))
        for prior in arrival.pose_priors:
            yield now, prior.residual(pose), prior.sqrt_information
        for shape in arrival.shape_priors:
            held = np.arange(shape.first, shape.first + shape.A.shape[1] // 2)
            yield self._columns(held), shape.residual(points[held]), shape.A
        root = np.eye(2) / NEWCOMER
        entering = [
            SplineFactor(arrival.pose, int(k), root, root @ q)
            for k, q in zip(arrival.control_points, seen, strict=True)
        ]
        observed = self.observe(arrival, pose, points)
        for rows in (*(spline_rows(factor, pose, points) for factor in entering), *observed):
            columns = np.append(now, self._columns(rows.control_points))
            yield columns, rows.residual, np.hstack([rows.by_pose, rows.by_points])

    def _update(self, now: Columns, pose: Float[np.ndarray, "3"], gradient: Float[np.ndarray, "a"]) -> None:
        """Move the means to the new optimum and note the pose as it is filtered."""
        factor = self._factor()
        step = -factor.solve(gradient)
        pose = pose + step[now]
        self.poses.append(np.append(pose[:2], se2.wrap(pose[2])))
        self.pose_covariances.append(self._covariance(factor, now))
        entered = np.flatnonzero(self.point_slots < self.used)
        self.control_points[entered] += step[self._columns(entered)].reshape(-1, 2)

    def _pose_columns(self, pose: int) -> Columns:
        return self.pose_slots[pose] + np.arange(3)

    def _columns(self, control_points: Int[np.ndarray, "m"]) -> Columns:
        return (self.point_slots[control_points][:, None] + np.arange(2)).ravel()

    def _factor(self) -> SuperLU:
        try:
            known = self.information[: self.used, : self.used]
            options = {"SymmetricMode": True}
            return splu(known, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:
            raise SolverError(f"the filter is singular after {len(self.poses)} key scans: {error}") from error

    def _covariance(self, factor: SuperLU, columns: Columns) -> np.ndarray:
        """Block of Λ⁻¹."""
        units = np.zeros((self.used, len(columns)))
        units[columns, np.arange(len(columns))] = 1.0
        block = factor.solve(units)[columns]
        return 0.5 * (block + block.T)


def slots(coming: Sequence[Arrival], control_points: int) -> tuple[Int[np.ndarray, "n"], Int[np.ndarray, "N"]]:
    """First column in Λ of each pose and of each control point: in the order in which they come in."""
    widths = np.array([3 + 2 * len(arrival.control_points) for arrival in coming])
    pose_slots, point_slots = np.cumsum(widths) - widths, np.empty(control_points, dtype=np.int64)
    for begin, arrival in zip(pose_slots, coming, strict=True):
        point_slots[arrival.control_points] = begin + 3 + 2 * np.arange(len(arrival.control_points))
    return pose_slots, point_slots


class KeyScanFilter(ABC):
    """What `ekf` and `bs_slam` share: one pass over the key scans. χ² compares filtered poses with the final map."""

    name: str

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or Stopping()

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The filtered estimate. Raises SolverError where a pose or spline hangs on nothing, and Cancelled."""
        curves, edges = pack_curves(graph), pack_edges(graph)
        state = InformationFilter(as_filtered(graph), self.observation(graph))
        watch = Watch(graph, curves, edges, progress)
        for arrival in state.coming:
            if cancelled():
                raise Cancelled(f"the filter was cancelled after {arrival.pose} key scans")
            state.arrive(arrival)
            watch.note(np.array(state.poses), state.control_points)
        end = State(np.array(state.poses), state.control_points)
        return estimate_of(graph, curves, edges, Descent(end, tuple(watch.records), converged=True))

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Of each pose as it was when its key scan came in, of splines after the last: the filter runs once more."""
        state = InformationFilter(as_filtered(estimate.graph), self.observation(estimate.graph))
        for arrival in unless_cancelled(cancelled, state.coming if poses or splines else ()):
            state.arrive(arrival)
        return Marginals(
            {pose: state.pose_covariances[pose] for pose in poses},
            {spline: state.spline_covariance(spline) for spline in splines},
        )

    @abstractmethod
    def observation(self, graph: Graph) -> Observe:
        """What the filter takes for an observation."""


def as_filtered(graph: Graph) -> Graph:
    """The graph as a filter can state it, checked for poses and splines that are left hanging.

    Without pose factors other than motion; and spline factors of no readings, which only fix the parametrisation of
    a curve, told by the pose with which their control points enter, for until then the curve would slide in itself.
    """
    motions = tuple(factor for factor in graph.pose_factors if is_motion(factor))
    enters = entries(graph)
    sights = tuple(
        factor if factor.readings else told_at_entry(graph, factor, enters) for factor in graph.spline_factors
    )
    alone = replace(graph, pose_factors=motions, spline_factors=sights)
    check_anchored(alone)
    return alone


def told_at_entry(graph: Graph, factor: SplineFactor, enters: Int[np.ndarray, "N"]) -> SplineFactor:
    """The same residual at the starting values, seen from the pose with which the last of its control points enters."""
    held = slice(factor.first, factor.first + factor.A.shape[1] // 2)
    pose, points = int(enters[held].max()), graph.control_points[held]
    turn = se2.rotation(graph.poses[pose, 2] - graph.poses[factor.pose, 2])
    A = (factor.A.reshape(-1, len(points), 2) @ turn).reshape(factor.A.shape)
    q = se2.transform(se2.inverse(graph.poses[pose]), points)
    residual = factor.residual(graph.poses[factor.pose], points)
    return replace(factor, pose=pose, A=A, b=A @ q.ravel() - residual)
