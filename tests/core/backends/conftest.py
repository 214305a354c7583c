"""A synthetic world for the back ends: a loop of poses, wavy walls seen from several of them, odometry and loops."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.graph import Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor

CURVATURE = np.array([1.0, -2.0, 1.0])


@dataclass(frozen=True, eq=False, slots=True)
class World:
    """A graph and the truth it was made from."""

    graph: Graph
    poses: np.ndarray
    control_points: np.ndarray


def true_poses(count: int) -> np.ndarray:
    """Once round a circle of 5 m radius, facing along it."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack([5 * np.cos(angle), 5 * np.sin(angle), se2.wrap(angle + np.pi / 2)])


def true_walls(count: int, points: int) -> np.ndarray:
    """Wavy walls one after another on a circle of 9 m radius."""
    angle = 2 * np.pi * np.arange(count * points) / (count * points)
    radius = 9 + 0.4 * np.sin(7 * angle)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def spline_factor(
    rng: np.random.Generator, noise: float, index: int, pose: np.ndarray, first: int, points: np.ndarray
) -> SplineFactor:
    """Each control point seen across the wall alone, and the two last ones not at all: A has no full rank."""
    m = len(points)
    seen = se2.transform(se2.inverse(pose), points)
    A = np.zeros((m, 2 * m))
    for row in range(m):
        k = row % (m - 2)
        A[row, 2 * k : 2 * k + 2] = rng.normal(size=2) * 80
        A[row, 2 * k + 2 : 2 * k + 4] = rng.normal(size=2) * 20
    return SplineFactor(index, first, A, A @ seen.ravel() + noise * rng.normal(size=m), readings=3 * m, constant=m)


def shape_prior(first: int, points: np.ndarray) -> ShapePrior:
    """Second differences as in the truth, so that what no beam saw is known too."""
    m = len(points)
    A = np.zeros((2 * (m - 2), 2 * m))
    for row in range(m - 2):
        for axis in range(2):
            A[2 * row + axis, 2 * row + axis : 2 * row + axis + 6 : 2] = 2.0 * CURVATURE
    return ShapePrior(first, A, A @ points.ravel())


def pose_factor(
    rng: np.random.Generator, noise: float, i: int, j: int, poses: np.ndarray, kernel: float | None = None
) -> PoseFactor:
    """Where j is, seen from i, with a full square root of its information."""
    sqrt_information = np.array([[30.0, 4.0, -2.0], [0.0, 25.0, 3.0], [0.0, 0.0, 60.0]])
    error = noise * np.linalg.solve(sqrt_information, rng.normal(size=3))
    measured = se2.compose(se2.between(poses[i], poses[j]), error)
    return PoseFactor(i, j, measured, sqrt_information, "odometry" if kernel is None else "loop", kernel)


def make_world(
    rng: np.random.Generator,
    *,
    poses: int = 12,
    walls: int = 3,
    points: int = 8,
    noise: float = 1.0,
    start_error: float = 0.03,
    outlier: bool = True,
    rigid: np.ndarray = se2.IDENTITY,
) -> World:
    """A graph with truth. `noise` scales that of the measurements, `rigid` moves the whole world."""
    robots = se2.compose(rigid, true_poses(poses))
    curve = se2.transform(rigid, true_walls(walls, points))
    factors = [
        spline_factor(rng, noise, i, robots[i], wall * points + shift, curve[wall * points + shift :][:5])
        for wall in range(walls)
        for i in range(poses)
        if (i + wall) % 3 != 0
        for shift in [int(rng.integers(0, points - 4))]
    ]
    edges = [pose_factor(rng, noise, i, i + 1, robots) for i in range(poses - 1)]
    edges += [pose_factor(rng, noise, i, (i + poses // 2) % poses, robots, kernel=2.0) for i in range(0, poses, 3)]
    if outlier:
        edges.append(PoseFactor(1, poses - 2, np.array([3.0, -2.0, 1.0]), 10 * np.eye(3), "loop", 1.0))
    start = robots + start_error * rng.normal(size=robots.shape) * (np.arange(poses) > 0)[:, None]
    graph = Graph(
        np.arange(poses) * 10,
        np.column_stack([start[:, :2], se2.wrap(start[:, 2])]),
        100 + np.arange(walls),
        points * np.arange(walls + 1),
        curve + start_error * rng.normal(size=curve.shape),
        tuple(factors),
        tuple(edges),
        (PosePrior(0, robots[0], np.diag([1e3, 1e3, 1e3])),),
        tuple(shape_prior(wall * points, curve[wall * points :][:points]) for wall in range(walls)),
    )
    return World(graph, robots, curve)


@pytest.fixture
def world() -> Callable[..., World]:
    """Builder of synthetic worlds: `world(rng, poses=…, noise=…)`."""
    return make_world
