"""A graph as it comes in, key scan by key scan: what each one brings, and where newcomers start.

A control point enters with the first key scan that observes it. A factor comes with the last pose it names, a shape
prior as soon as all its control points have entered.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.graph import Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor

PREDICTION_STEPS = 3
"""Gauss-Newton steps to fuse the motion factors between two poses."""


@dataclass(frozen=True, eq=False, slots=True)
class Arrival:
    """What one key scan brings: its pose, the control points that enter, and all factors that can be stated now."""

    pose: int
    control_points: Int[np.ndarray, "m"]
    spline_factors: tuple[SplineFactor, ...]
    pose_factors: tuple[PoseFactor, ...]
    pose_priors: tuple[PosePrior, ...]
    shape_priors: tuple[ShapePrior, ...]


def arrivals(graph: Graph) -> tuple[Arrival, ...]:
    """One arrival per pose, in their order; control points that no factor observes enter with the last."""
    n, enters = len(graph.poses), entries(graph)
    sights: list[list[SplineFactor]] = [[] for _ in range(n)]
    edges: list[list[PoseFactor]] = [[] for _ in range(n)]
    priors: list[list[PosePrior]] = [[] for _ in range(n)]
    shapes: list[list[ShapePrior]] = [[] for _ in range(n)]
    for factor in graph.spline_factors:
        sights[factor.pose].append(factor)
    for factor in graph.pose_factors:
        edges[max(factor.i, factor.j)].append(factor)
    for prior in graph.pose_priors:
        priors[prior.pose].append(prior)
    for shape in graph.shape_priors:
        shapes[int(enters[shape.first : shape.first + shape.A.shape[1] // 2].max())].append(shape)
    return tuple(
        Arrival(i, np.flatnonzero(enters == i), tuple(sights[i]), tuple(edges[i]), tuple(priors[i]), tuple(shapes[i]))
        for i in range(n)
    )


def entries(graph: Graph) -> Int[np.ndarray, "N"]:
    """The pose with which each control point enters."""
    enters = np.full(len(graph.control_points), len(graph.poses) - 1, dtype=np.int64)
    for factor in graph.spline_factors:
        seen = slice(factor.first, factor.first + factor.A.shape[1] // 2)
        enters[seen] = np.minimum(enters[seen], factor.pose)
    return enters


def predicted_pose(graph: Graph, arrival: Arrival, last: Float[np.ndarray, "3"] | None) -> Float[np.ndarray, "3"]:
    """Where the pose of an arrival starts, given the estimate of the one before it (None: it is the first).

    What all motion factors between the two say together, else as the graph's starting values lie to each other.
    """
    i = arrival.pose
    if last is None:
        return graph.poses[i]
    motions = [factor for factor in arrival.pose_factors if is_motion(factor) and factor.i == i - 1]
    if not motions:
        return se2.compose(last, se2.between(graph.poses[i - 1], graph.poses[i]))
    pose = se2.compose(last, motions[0].measured)
    for _ in range(PREDICTION_STEPS if len(motions) > 1 else 0):
        jacobian = np.vstack([motion.jacobians(last, pose)[1] for motion in motions])
        residual = np.concatenate([motion.residual(last, pose) for motion in motions])
        pose = pose - np.linalg.lstsq(jacobian, residual)[0]
    return np.append(pose[:2], se2.wrap(pose[2]))


def is_motion(factor: PoseFactor) -> bool:
    """Whether it tells how the robot moved from one key scan to the next: odometry and scan matching do."""
    return abs(factor.i - factor.j) == 1 and factor.kernel is None


def first_seen(graph: Graph, arrival: Arrival) -> Float[np.ndarray, "m 2"]:
    """The control points that enter, relative to the pose that sees them, by the graph's starting values.

    From there they start, wherever the pose turns out to be.
    """
    return se2.transform(se2.inverse(graph.poses[arrival.pose]), graph.control_points[arrival.control_points])


def carried_on(graph: Graph, poses: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "n 3"]:
    """The poses reached so far, and those to come hanging on the last of them as in the starting values."""
    k = len(poses)
    ahead = se2.between(graph.poses[k - 1], graph.poses[k:])
    return np.concatenate([poses, se2.compose(poses[-1], ahead)])
