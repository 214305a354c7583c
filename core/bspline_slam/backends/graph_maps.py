"""A graph as local maps: one per key scan, holding what becomes known with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from bspline_slam import se2
from bspline_slam.backends.gauss_newton import STEP_INFORMATION
from bspline_slam.backends.local_maps import WORLD, LocalMaps, Statement
from bspline_slam.graph import Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor

NO_POSES = np.empty(0, dtype=np.int64)


def local_maps_of(graph: Graph) -> LocalMaps:
    """Map i holds the spline factors of pose i, pose factors between i and poses before it, the priors of i, and the
    shape priors whose control points all have been seen by then (or never will be)."""
    seen = first_seen(graph)
    maps: list[list[Statement]] = [[] for _ in graph.poses]
    for edge in graph.pose_factors:
        maps[max(edge.i, edge.j)].append(_of_edge(edge))
    for spline in graph.spline_factors:
        maps[spline.pose].append(_of_points(spline, spline.pose))
    for shape in graph.shape_priors:
        maps[int(seen[_held(shape)].max())].append(_of_points(shape, WORLD))
    for prior in graph.pose_priors:
        maps[prior.pose].append(_of_prior(prior))
    return LocalMaps.from_statements(maps, hold=STEP_INFORMATION)


def first_maps(graph: Graph, count: int) -> Graph:
    """The graph of what the first local maps hold, so many."""
    seen = first_seen(graph)
    return replace(
        graph,
        spline_factors=tuple(factor for factor in graph.spline_factors if factor.pose < count),
        pose_factors=tuple(factor for factor in graph.pose_factors if max(factor.i, factor.j) < count),
        pose_priors=tuple(prior for prior in graph.pose_priors if prior.pose < count),
        shape_priors=tuple(shape for shape in graph.shape_priors if seen[_held(shape)].max() < count),
    )


def first_seen(graph: Graph) -> Int[np.ndarray, "N"]:
    """The first pose that observes each control point; the last of all poses where none does."""
    first = np.full(len(graph.control_points), len(graph.poses) - 1)
    for factor in graph.spline_factors:
        points = slice(factor.first, factor.first + factor.A.shape[1] // 2)
        first[points] = np.minimum(first[points], factor.pose)
    return first


def _of_points(factor: SplineFactor | ShapePrior, frame: int) -> Statement:
    return Statement(frame, NO_POSES, _held(factor), factor.A, np.zeros(factor.A.shape[1]), factor.b)


def _held(factor: SplineFactor | ShapePrior) -> Int[np.ndarray, "m"]:
    """The control points that a factor speaks of."""
    return np.arange(factor.first, factor.first + factor.A.shape[1] // 2)


def _of_edge(factor: PoseFactor) -> Statement:
    """R_zᵀ(t − z_xy) of the relative pose (t, θ) is W·((t, θ) ⊖ z) with W turned by R_zᵀ."""
    W = factor.sqrt_information.copy()
    W[:, :2] = W[:, :2] @ se2.rotation(-factor.measured[2])
    kernel = np.inf if factor.kernel is None else factor.kernel
    return Statement(factor.i, np.array([factor.j]), NO_POSES, W, factor.measured, np.zeros(3), kernel)


def _of_prior(prior: PosePrior) -> Statement:
    return Statement(WORLD, np.array([prior.pose]), NO_POSES, prior.sqrt_information, prior.mean, np.zeros(3))
