"""Idle knots leave, those that carry the shape stay."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.adjustment.knots import ALONG, on_inner_knots, without_idle_knots
from bspline_slam.bspline import BSpline, uniform_knots

GAIN = 1.0


def measured(
    curve: BSpline, rng: np.random.Generator, count: int, sigma: float = 0.01
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = rng.uniform(*curve.domain, count)
    return t, curve.normals(t), np.full(count, 1.0 / sigma)


def straight(count: int, degree: int = 3) -> BSpline:
    knots = uniform_knots(0.0, 0.4, count, degree)
    bare = BSpline(degree, knots, np.zeros((count, 2)))
    return bare.with_control_points(np.outer(bare.greville(), [0.6, 0.8]))


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_a_straight_wall_keeps_two_control_points(degree: int) -> None:
    curve = straight(20, degree)
    thin = without_idle_knots(curve, *measured(curve, np.random.default_rng(1), 400), GAIN).curve
    assert len(thin.control_points) == 2
    assert thin.domain == curve.domain
    t = np.linspace(*curve.domain, 50)
    np.testing.assert_allclose(thin(t), curve(t), atol=1e-6)


def test_knots_stay_where_the_curve_bends() -> None:
    curve = straight(30)
    bump = 0.3 * np.exp(-0.5 * np.square((np.arange(30) - 9) / 1.5))
    curve = curve.with_control_points(curve.control_points + np.outer(bump, [-0.8, 0.6]))
    t, normals, weight = measured(curve, np.random.default_rng(2), 3000)
    thin = without_idle_knots(curve, t, normals, weight, GAIN).curve
    assert 6 <= len(thin.control_points) < 20
    assert np.count_nonzero(np.abs(thin.knots[4:-4] - curve.greville()[9]) < 1.0) >= 2
    across = ((thin(t) - curve(t)) * normals).sum(1) * weight
    assert across @ across <= GAIN * (30 - len(thin.control_points))


def test_dropping_nothing_is_allowed_when_everything_matters() -> None:
    rng = np.random.default_rng(3)
    curve = straight(8)
    curve = curve.with_control_points(curve.control_points + rng.normal(0.0, 0.2, (8, 2)))
    found = without_idle_knots(curve, *measured(curve, rng, 5000, 1e-4), GAIN)
    assert found.curve is curve
    assert found.left_out == 0.0


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_curve_takes_no_more_than_it_needs(degree: int) -> None:
    curve, rng = straight(12), np.random.default_rng(5)
    kept = np.isin(np.arange(8), [2, 5])
    plain = on_inner_knots(curve, degree, kept)
    bent = np.outer(plain.greville(), [0.6, 0.8]) + np.outer(rng.normal(0.0, 0.1, degree + 3), [-0.8, 0.6])
    wanted = plain.with_control_points(bent)
    t = np.linspace(*curve.domain, 500)
    fine = curve.with_control_points(np.linalg.lstsq(curve.basis(t), wanted(t), rcond=None)[0])
    thin = without_idle_knots(fine, t, fine.normals(t), np.full(len(t), 50.0), GAIN).curve
    assert plain.domain == thin.domain == curve.domain
    assert len(thin.control_points) <= len(wanted.control_points)
    assert np.abs(((thin(t) - wanted(t)) * fine.normals(t)).sum(1)).max() < 0.02


def test_losses_are_those_of_the_beams_themselves() -> None:
    curve, rng = straight(30), np.random.default_rng(6)
    curve = curve.with_control_points(curve.control_points + rng.normal(0.0, 0.02, (30, 2)))
    t, normals, weight = measured(curve, rng, 4000)
    for gain in (1.0, 3.0):
        thin = without_idle_knots(curve, t, normals, weight, gain).curve
        across = ((thin(t) - curve(t)) * normals).sum(1) * weight
        assert across @ across <= 1.05 * gain * (30 - len(thin.control_points))


@pytest.mark.parametrize("gain", [3.0, 8.0])
def test_each_knot_that_stays_earns_its_gain(gain: float) -> None:
    curve, rng = straight(30), np.random.default_rng(7)
    curve = curve.with_control_points(curve.control_points + rng.normal(0.0, 0.004, (30, 2)))
    t, normals, weight = measured(curve, rng, 4000)
    thin = without_idle_knots(curve, t, normals, weight, gain).curve
    inner = thin.knots[thin.degree + 1 : len(thin.control_points)]
    least = lost_by(curve, thin, t, normals, weight)
    for knot in range(len(inner)):
        kept = np.isin(curve.knots[4:30], np.delete(inner, knot))
        fewer = on_inner_knots(curve, thin.degree, kept)
        ways = ((normals, weight), (normals @ [[0.0, -1.0], [1.0, 0.0]], ALONG * weight))
        rows = [(fewer.basis(t)[:, :, None] * (n * w[:, None])[:, None, :]).reshape(len(t), -1) for n, w in ways]
        right = [(curve(t) * n).sum(1) * w for n, w in ways]
        found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0].reshape(-1, 2)
        assert lost_by(curve, fewer.with_control_points(found), t, normals, weight) > least + 0.9 * gain


def lost_by(curve: BSpline, plain: BSpline, t: np.ndarray, normals: np.ndarray, weight: np.ndarray) -> float:
    across = ((plain(t) - curve(t)) * normals).sum(1) * weight
    return float(across @ across)


@pytest.mark.parametrize("waves", [0.002, 0.0003])
def test_a_wall_strays_from_a_plain_curve_as_far_as_it_says(waves: float) -> None:
    rng, shape, gain = np.random.default_rng(8), straight(12), 8.0
    off, told = [], []
    for _ in range(60):
        wall = shape.with_control_points(shape.control_points + np.outer(rng.normal(0.0, waves, 12), [-0.8, 0.6]))
        t, normals, weight = measured(shape, rng, 800)
        B = shape.basis(t)
        noise = np.linalg.lstsq(B, rng.normal(0.0, 0.01, len(t)), rcond=None)[0]
        seen = wall.with_control_points(wall.control_points + np.outer(noise, [-0.8, 0.6]))
        plain = without_idle_knots(seen, t, normals, weight, gain)
        places = np.linspace(*shape.domain, 40)
        off.append(np.mean(((plain.curve(places) - wall(places)) @ [-0.8, 0.6]) ** 2))
        n = len(plain.curve.control_points)
        told.append(plain.left_out + 0.01**2 * n / len(t))
    assert np.mean(told) == pytest.approx(np.mean(off), rel=0.3)
