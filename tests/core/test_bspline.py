"""B-spline curves: the basis, points near and rays through the curve, and changed curves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline as ScipyBSpline

from bspline_slam import se2
from bspline_slam.bspline import BSpline, basis_rows, clamped_knots, uniform_knots
from bspline_slam.errors import GeometryError


@st.composite
def curves(draw: st.DrawFn, most_degree: int = 4) -> BSpline:
    """Clamped, uniform and irregular curves of degree 1 up to `most_degree`."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    degree = draw(st.integers(1, most_degree))
    count = degree + 1 + draw(st.integers(0, 6))
    kind = draw(st.sampled_from(["clamped", "uniform", "irregular"]))
    if kind == "clamped":
        knots = clamped_knots(count, degree)
    elif kind == "uniform":
        knots = uniform_knots(rng.normal(), rng.uniform(0.2, 0.6), count, degree)
    else:
        knots = np.cumsum(rng.uniform(0.1, 1.0, count + degree + 1))
    way = np.cumsum(rng.uniform(0.2, 0.5, count))
    return BSpline(degree, knots, np.stack([way, rng.normal(0.0, 0.3, count)], -1))


def inside(curve: BSpline, count: int = 41) -> np.ndarray:
    return np.linspace(*curve.domain, count)


# -- the basis ---------------------------------------------------------------------------------------------------


@given(curves())
def test_basis_functions_are_not_negative_and_sum_to_one(curve: BSpline) -> None:
    basis = curve.basis(inside(curve))
    assert basis.min() >= -1e-12
    np.testing.assert_allclose(basis.sum(1), 1.0, atol=1e-12)


@given(curves())
def test_basis_functions_live_on_degree_plus_one_knot_intervals(curve: BSpline) -> None:
    t = inside(curve)
    basis = curve.basis(t)
    for i in range(len(curve.control_points)):
        outside = (t < curve.knots[i]) | (t > curve.knots[i + curve.degree + 1])
        np.testing.assert_array_equal(basis[outside, i], 0.0)


@given(curves(), st.integers(0, 3))
def test_values_and_derivatives_agree_with_scipy(curve: BSpline, derivative: int) -> None:
    t = inside(curve, 33)[1:-1]
    theirs = ScipyBSpline(curve.knots, curve.control_points, curve.degree)(t, nu=derivative)
    away_from_knots = np.abs(t[:, None] - curve.knots).min(1) > 1e-9
    np.testing.assert_allclose(curve(t, derivative)[away_from_knots], theirs[away_from_knots], rtol=1e-9, atol=1e-8)


@given(curves())
def test_derivatives_agree_with_central_differences(curve: BSpline) -> None:
    t, step = inside(curve), 1e-6
    smooth = np.abs(t[:, None] - curve.knots).min(1) > 2 * step
    t = t[smooth]
    for derivative in range(curve.degree):
        slope = (curve(t + step, derivative) - curve(t - step, derivative)) / (2 * step)
        size = 1.0 + np.abs(slope).max(initial=0.0)
        np.testing.assert_allclose(curve(t, derivative + 1), slope, atol=1e-5 * size)


@given(curves())
def test_derivatives_beyond_the_degree_vanish(curve: BSpline) -> None:
    np.testing.assert_array_equal(curve(inside(curve), curve.degree + 1), 0.0)


@given(curves(), st.floats(-0.05, 0.05))
def test_beyond_the_domain_the_end_pieces_go_on_as_polynomials(curve: BSpline, beyond: float) -> None:
    for end, sign in zip(curve.domain, (-1, 1), strict=True):
        out = np.array([end + sign * abs(beyond)])
        piece = end - sign * np.linspace(0.0, 1.0, curve.degree + 2)[1:] * 1e-1 * smallest_step(curve)
        weights = [np.prod([(out[0] - b) / (a - b) for b in piece if b != a]) for a in piece]
        np.testing.assert_allclose(curve(out)[0], np.array(weights) @ curve(piece), rtol=1e-4, atol=1e-4)


def smallest_step(curve: BSpline) -> float:
    steps = np.diff(curve.knots[curve.degree : len(curve.control_points) + 1])
    return float(steps[steps > 0].min())


def test_rows_hold_the_basis_functions_that_do_not_vanish() -> None:
    first, values = basis_rows(uniform_knots(0.0, 1.0, 6), 3, np.array([0.0, 1.5, 3.0]))
    np.testing.assert_array_equal(first, [0, 1, 2])
    np.testing.assert_allclose(values[0], [1 / 6, 4 / 6, 1 / 6, 0.0])


@given(curves(), st.tuples(*[st.floats(-5, 5)] * 3))
def test_moving_the_control_points_moves_the_curve(curve: BSpline, frame: tuple[float, float, float]) -> None:
    pose, t = np.array(frame), inside(curve)
    moved = curve.with_control_points(se2.transform(pose, curve.control_points))
    np.testing.assert_allclose(moved(t), se2.transform(pose, curve(t)), atol=1e-9)
    np.testing.assert_allclose(moved.normals(t), se2.rotate(pose, curve.normals(t)), atol=1e-6)


@given(curves())
def test_normals_are_unit_and_across_the_tangent(curve: BSpline) -> None:
    t = inside(curve)
    tangent, normal = curve(t, 1), curve.normals(t)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    np.testing.assert_allclose(np.sum(tangent * normal, axis=1), 0.0, atol=1e-9)


# -- where things meet the curve ---------------------------------------------------------------------------------


@given(curves(3), st.integers(0, 2**32 - 1))
def test_nothing_on_the_curve_is_nearer_than_the_foot_point(curve: BSpline, seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = rng.uniform(*curve.domain, 12)
    points = curve(t) + rng.normal(0.0, 0.05, (12, 2))
    foot = curve.foot_points(points, iterations=30)
    dense = curve(inside(curve, 2001))
    best = np.linalg.norm(points[:, None] - dense, axis=2).min(1)
    distance = np.linalg.norm(points - curve(foot), axis=1)
    assert (distance <= best + 1e-3).all()
    assert ((curve.domain[0] <= foot) & (foot <= curve.domain[1])).all()


@given(curves(3), st.integers(0, 2**32 - 1))
def test_points_of_the_curve_are_their_own_foot_points(curve: BSpline, seed: int) -> None:
    t = np.random.default_rng(seed).uniform(*curve.domain, 12)
    points = curve(t)
    np.testing.assert_allclose(curve(curve.foot_points(points, iterations=30)), points, atol=1e-6)


@given(curves(3), st.integers(0, 2**32 - 1))
def test_ray_hits_lie_on_the_ray_and_on_the_curve_and_nothing_is_nearer(curve: BSpline, seed: int) -> None:
    rng = np.random.default_rng(seed)
    origin = np.array([rng.uniform(0.0, 3.0), rng.choice([-2.0, 2.0])])
    angle = rng.uniform(-np.pi, np.pi, 30)
    directions = np.stack([np.cos(angle), np.sin(angle)], -1)
    ranges, parameters = curve.ray_hits(origin, directions)
    hit = np.isfinite(ranges)
    np.testing.assert_array_equal(hit, np.isfinite(parameters))
    ends = origin + ranges[hit, None] * directions[hit]
    np.testing.assert_allclose(curve(parameters[hit]) if hit.any() else ends, ends, atol=1e-9)
    dense = curve(inside(curve, 4001)) - origin
    for direction, distance in zip(directions, ranges, strict=True):
        along = dense @ direction
        across = direction[0] * dense[:, 1] - direction[1] * dense[:, 0]
        crossings = (across[:-1] * across[1:] < 0) & (along[:-1] > 0)
        if np.isnan(distance):
            assert not crossings.any()
        elif crossings.any():
            assert distance <= along[:-1][crossings].min() + 0.01


def test_a_ray_meets_the_nearer_of_two_walls() -> None:
    bent = BSpline(1, clamped_knots(4, 1), np.array([[2.0, -1.0], [2.0, 1.0], [4.0, 1.0], [4.0, -1.0]]))
    ranges, _ = bent.ray_hits(np.zeros(2), np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]]))
    np.testing.assert_allclose(ranges, [2.0, np.nan, np.nan])


def test_length_of_a_straight_and_of_a_round_curve() -> None:
    straight = BSpline(3, clamped_knots(6), np.stack([np.linspace(0, 5, 6), np.zeros(6)], -1))
    np.testing.assert_allclose(straight.length(), 5.0)
    angle = np.arange(80) * 2 * np.pi / 64
    ring = BSpline(3, uniform_knots(0.0, 1.0, 67), np.stack([np.cos(angle), np.sin(angle)], -1)[:67])
    np.testing.assert_allclose(ring.length(), 2 * np.pi, rtol=3e-3)


@given(curves(3), st.floats(0.05, 0.5))
def test_samples_are_evenly_spaced_from_end_to_end(curve: BSpline, spacing: float) -> None:
    t, points = curve.sample(spacing)
    assert (t[0], t[-1]) == curve.domain
    assert (np.diff(t) > 0).all()
    np.testing.assert_array_equal(points, curve(t))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= 1.5 * spacing


# -- changed curves ----------------------------------------------------------------------------------------------


@given(curves(), st.floats(0.01, 0.99))
def test_a_knot_more_does_not_change_the_curve(curve: BSpline, share: float) -> None:
    a, b = curve.domain
    finer = curve.insert_knot(a + share * (b - a))
    assert len(finer.control_points) == len(curve.control_points) + 1
    assert finer.domain == curve.domain
    t = inside(curve)
    np.testing.assert_allclose(finer(t), curve(t), atol=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_knots_may_pile_up_to_a_corner(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = BSpline(3, uniform_knots(0.0, 1.0, 8), rng.normal(size=(8, 2)))
    t = inside(curve)
    piled = curve
    for _ in range(3):
        piled = piled.insert_knot(2.5)
        np.testing.assert_allclose(piled(t), curve(t), atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(0, 3), st.integers(0, 3))
def test_growing_leaves_the_old_stretch_alone_and_goes_straight_on(seed: int, before: int, after: int) -> None:
    rng = np.random.default_rng(seed)
    curve = BSpline(3, uniform_knots(1.0, 0.4, 7), rng.normal(size=(7, 2)))
    grown = curve.extended(before, after)
    np.testing.assert_allclose(grown.domain, [curve.domain[0] - 0.4 * before, curve.domain[1] + 0.4 * after])
    np.testing.assert_array_equal(grown.control_points[before : before + 7], curve.control_points)
    t = inside(curve)
    np.testing.assert_allclose(grown(t), curve(t), atol=1e-9)
    ends = np.diff(grown.control_points, n=2, axis=0)
    np.testing.assert_allclose(ends[:before], 0.0, atol=1e-9)
    np.testing.assert_allclose(ends[len(ends) - after :], 0.0, atol=1e-9)


@given(curves())
def test_reversed_runs_through_the_same_points(curve: BSpline) -> None:
    back = curve.reversed()
    np.testing.assert_allclose(back(inside(back)), curve(inside(curve))[::-1], atol=1e-9)
    np.testing.assert_allclose(back.reversed().knots, curve.knots, atol=1e-9)


@given(curves(), st.floats(0.0, 0.9), st.floats(0.01, 0.1))
def test_only_active_control_points_shape_a_stretch(curve: BSpline, start: float, length: float) -> None:
    a, b = curve.domain
    span = (a + start * (b - a), a + (start + length) * (b - a))
    active = curve.active(span)
    t = np.linspace(*span, 11)
    changed = np.where(active[:, None], curve.control_points, curve.control_points + 1.0)
    np.testing.assert_array_equal(curve.with_control_points(changed)(t), curve(t))
    assert curve.basis(t)[:, active].max(0).min() >= 0.0


# -- refused -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("degree", "knots", "count", "sentence"),
    [
        (0, [0.0, 1.0], 1, "degree of at least 1, got 0"),
        (3, clamped_knots(4), 3, "degree-3 spline needs at least 4 control points, got 3"),
        (3, clamped_knots(5), 4, "4 control points of degree 3 need 8 knots, got 9"),
        (1, [0.0, 1.0, 0.5, 2.0], 2, "knots must not decrease"),
        (1, [0.0, 1.0, 1.0, 2.0], 2, "the domain must not be empty"),
    ],
)
def test_numbers_that_make_no_curve(degree: int, knots: list[float], count: int, sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        BSpline(degree, np.asarray(knots, dtype=float), np.zeros((count, 2)))


@pytest.mark.parametrize("t", [-0.1, 0.0, 1.0, 1.1])
def test_a_knot_outside_the_domain_is_refused(t: float) -> None:
    curve = BSpline(3, clamped_knots(5), np.zeros((5, 2)))
    with pytest.raises(GeometryError, match="a knot can be inserted inside"):
        curve.insert_knot(t)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_curve_that_reaches_farther_goes_on_as_its_end_pieces_do(degree: int) -> None:
    curve = BSpline(degree, uniform_knots(0.0, 0.4, 9, degree), np.random.default_rng(3).normal(size=(9, 2)))
    low, high = curve.domain
    wide = curve.reaching((low - 0.05, high + 0.1))
    assert wide.domain == pytest.approx((low - 0.05, high + 0.1))
    t = np.linspace(*wide.domain, 60)
    np.testing.assert_allclose(wide(t), curve(t), atol=1e-9)
    assert curve.reaching((low + 0.1, high)) is curve


@pytest.mark.parametrize("span", [(0.1, 1.7), (0.0, 2.0), (0.4, 2.4), (0.85, 1.15)])
def test_a_curve_clamped_to_a_span_is_the_same_there_and_nowhere_else(span: tuple[float, float]) -> None:
    curve = BSpline(3, uniform_knots(0.0, 0.4, 9), np.random.default_rng(3).normal(size=(9, 2)))
    clamped = curve.clamped(span)
    t = np.linspace(*span, 40)
    assert clamped.domain == pytest.approx(span)
    assert np.allclose(clamped(t), curve(t))
    for end, inside in zip(span, (span[0] > 0.0, span[1] < 2.4), strict=True):
        assert not inside or np.abs(clamped.control_points - curve(np.array([end]))).sum(axis=1).min() < 1e-12
