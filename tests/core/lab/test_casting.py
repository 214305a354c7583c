"""Rays against curves: the same hits as curve by curve, whichever way the rays go."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.errors import GeometryError
from bspline_slam.lab.casting import Obstacles


def curves(rng: np.random.Generator, count: int) -> list[BSpline]:
    """Curves with bends of every kind in a square of 20 m."""
    starts = rng.uniform(-10, 10, (count, 1, 2))
    points = starts + np.cumsum(rng.normal(0.0, 0.5, (count, 7, 2)), axis=1)
    return [BSpline(k % 4 + 1, clamped_knots(7, k % 4 + 1), each) for k, each in enumerate(points)]


def rays(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins inside and outside of that square, directions all around, some along the axes."""
    angle = np.concatenate([rng.uniform(-np.pi, np.pi, count - 4), np.pi / 2 * np.arange(4)])
    return rng.uniform(-13, 13, (count, 2)), np.stack([np.cos(angle), np.sin(angle)], -1)


def test_hits_are_those_of_each_curve_by_itself() -> None:
    rng = np.random.default_rng(1)
    world = curves(rng, 30)
    origins, directions = rays(rng, 400)
    reach, met = Obstacles.from_curves(world).hits(origins, directions, 100.0)
    table = np.array(
        [[curve.ray_hits(o, u[None])[0][0] for curve in world] for o, u in zip(origins, directions, strict=True)]
    )
    expected = np.where(np.isnan(table), np.inf, table)
    assert np.count_nonzero(np.isfinite(reach)) > 100
    same = np.isclose(reach, expected.min(1), atol=1e-6) | (np.isinf(reach) & np.isinf(expected.min(1)))
    assert same.mean() > 0.99  # rays that graze a curve may be told differently
    assert np.array_equal(met[same & np.isfinite(reach)], expected.argmin(1)[same & np.isfinite(reach)])
    assert np.all(met[np.isinf(reach)] == -1)


def test_nothing_is_met_beyond_the_reach() -> None:
    rng = np.random.default_rng(2)
    obstacles = Obstacles.from_curves(curves(rng, 20))
    origins, directions = rays(rng, 800)
    far, _ = obstacles.hits(origins, directions, 100.0)
    near, met = obstacles.hits(origins, directions, 4.0)
    assert np.all(np.where(far < 4.0, near == far, np.isinf(near)))
    assert np.array_equal(met >= 0, far < 4.0)


def test_without_curves_there_is_nothing_to_meet() -> None:
    with pytest.raises(GeometryError, match="no curve"):
        Obstacles.from_curves([])
