"""Samples of splines: what is near a scan is found, whatever was held, replaced and dropped before."""

from __future__ import annotations

import numpy as np

from bspline_slam.association import AssociationConfig
from bspline_slam.front_end.samples import Samples

CONFIG = AssociationConfig()
T = np.arange(0.0, 4.0, 0.05)


def wall(y: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parameters, points and normals of a wall along x at a height of y."""
    return T, np.column_stack([T, np.full(len(T), y)]), np.tile([0.0, 1.0], (len(T), 1))


def seen(samples: Samples, y: float) -> list[int]:
    """The splines that explain points 2 cm above y, nearest first."""
    points = np.column_stack([np.linspace(1.0, 3.0, 9), np.full(9, y + 0.02)])
    near = samples.near(points, np.tile([0.0, 1.0], (9, 1)), CONFIG)
    assert (near.spline == near.spline[0]).all()
    return [int(spline) for spline in near.spline[0] if spline >= 0]


def test_each_wall_is_found_where_it_is_and_nowhere_else() -> None:
    samples = Samples()
    for spline in range(100):
        samples.put(spline, *wall(float(spline)))
    assert [seen(samples, float(spline)) for spline in range(100)] == [[spline] for spline in range(100)]
    assert seen(samples, 0.5) == []


def test_what_is_held_anew_is_found_only_where_it_is_now() -> None:
    samples, rng = Samples(), np.random.default_rng(1)
    where: dict[int, float] = {}
    for _ in range(300):
        spline, y = int(rng.integers(12)), float(rng.integers(40))
        if y in where.values():
            continue
        samples.put(spline, *wall(y))
        where[spline] = y
    assert all(seen(samples, y) == [spline] for spline, y in where.items())
    assert seen(samples, next(float(y) for y in range(40) if y not in where.values())) == []


def test_what_was_dropped_is_gone() -> None:
    samples = Samples()
    samples.put(3, *wall(0.0))
    samples.put(4, *wall(0.05))
    assert seen(samples, 0.0) == [3, 4]
    samples.drop(3)
    assert seen(samples, 0.0) == [4]


def test_parameter_and_distance_are_those_of_the_foot() -> None:
    samples = Samples()
    samples.put(0, *wall(0.0))
    points = np.array([[1.02, 0.03], [2.51, -0.06], [4.5, 0.0]])
    near = samples.near(points, np.tile([0.0, 1.0], (3, 1)), CONFIG)
    np.testing.assert_array_equal(near.spline[:, 0], [0, 0, -1])
    np.testing.assert_allclose(near.t[:2, 0], points[:2, 0], atol=1e-12)
    np.testing.assert_allclose(near.across[:2, 0], points[:2, 1], atol=1e-12)


def test_a_wall_that_faces_away_explains_nothing() -> None:
    samples = Samples()
    samples.put(0, *wall(0.0))
    assert (samples.near(np.array([[1.0, 0.01]]), np.array([[0.0, -1.0]]), CONFIG).spline == -1).all()
