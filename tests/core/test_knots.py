"""Idle knots leave, those that carry the shape stay."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.knots import greville, polynomials, refinement, without_idle_knots

GAIN = 1.0


def measured(
    curve: BSpline, rng: np.random.Generator, count: int, sigma: float = 0.01
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = rng.uniform(*curve.domain, count)
    return t, curve.normals(t), np.full(count, 1.0 / sigma)


def straight(count: int, degree: int = 3) -> BSpline:
    knots = uniform_knots(0.0, 0.4, count, degree)
    bare = BSpline(degree, knots, np.zeros((count, 2)))
    return bare.with_control_points(np.outer(greville(bare), [0.6, 0.8]))


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_a_straight_wall_keeps_two_control_points(degree: int) -> None:
    curve = straight(20, degree)
    thin = without_idle_knots(curve, *measured(curve, np.random.default_rng(1), 400), GAIN)
    assert len(thin.control_points) == 2
    assert thin.domain == curve.domain
    t = np.linspace(*curve.domain, 50)
    np.testing.assert_allclose(thin(t), curve(t), atol=1e-6)


def test_knots_stay_where_the_curve_bends() -> None:
    curve = straight(30)
    bump = 0.3 * np.exp(-0.5 * np.square((np.arange(30) - 9) / 1.5))
    curve = curve.with_control_points(curve.control_points + np.outer(bump, [-0.8, 0.6]))
    t, normals, weight = measured(curve, np.random.default_rng(2), 3000)
    thin = without_idle_knots(curve, t, normals, weight, GAIN)
    assert 6 <= len(thin.control_points) < 20
    assert np.count_nonzero(np.abs(thin.knots[4:-4] - greville(curve)[9]) < 1.0) >= 2
    across = ((thin(t) - curve(t)) * normals).sum(1) * weight
    assert across @ across <= GAIN * (30 - len(thin.control_points))


def test_dropping_nothing_is_allowed_when_everything_matters() -> None:
    rng = np.random.default_rng(3)
    curve = straight(8)
    curve = curve.with_control_points(curve.control_points + rng.normal(0.0, 0.2, (8, 2)))
    assert without_idle_knots(curve, *measured(curve, rng, 5000, 1e-4), GAIN) is curve


def test_refinement_keeps_the_curve() -> None:
    curve, rng = straight(10), np.random.default_rng(4)
    t = np.linspace(*curve.domain, 40)
    fewer = BSpline(3, np.delete(curve.knots, [5, 7]), np.zeros((8, 2)))
    for plain in (fewer, *polynomials(curve)):
        coarse = plain.with_control_points(rng.normal(size=plain.control_points.shape))
        fine = curve.with_control_points(refinement(curve, plain) @ coarse.control_points)
        np.testing.assert_allclose(fine(t), coarse(t), atol=1e-9)


def test_an_arc_takes_the_degree_that_it_needs() -> None:
    curve = straight(12)
    t, _, weight = measured(curve, np.random.default_rng(5), 2000)
    parabola = next(plain for plain in polynomials(curve) if plain.degree == 2)
    bent = parabola.with_control_points(np.array([[0.0, 0.0], [1.5, 1.0], [3.0, 0.0]]))
    curve = curve.with_control_points(refinement(curve, bent) @ bent.control_points)
    thin = without_idle_knots(curve, t, curve.normals(t), weight, GAIN)
    assert thin.degree == 2
    np.testing.assert_allclose(thin.control_points, bent.control_points, atol=1e-6)
