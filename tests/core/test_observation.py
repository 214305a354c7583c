"""Observations: the QR identity to the last digit, no information along a wall, and the paper's model."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.fitting import FittingConfig
from bspline_slam.kernels import curves as kernels
from bspline_slam.observation import across_sigma, chord_length, compress, normal_distance

SEEDS = st.integers(0, 10_000)


def drawn(seed: int, m: int, degree: int = 3) -> tuple[BSpline, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A random curve, parameters, unit normals, points and standard deviations."""
    rng = np.random.default_rng(seed)
    control = np.stack([np.arange(9.0), rng.normal(size=9)], -1)
    curve = BSpline(degree, uniform_knots(0.0, 0.4, 9, degree), control)
    t = np.sort(rng.uniform(*curve.domain, m))
    angle = rng.uniform(-np.pi, np.pi, m)
    normals = np.stack([np.cos(angle), np.sin(angle)], -1)
    return curve, t, normals, rng.normal(size=(m, 2)), rng.uniform(0.01, 0.1, m)


@given(SEEDS, st.integers(1, 60), st.integers(1, 12))
def test_compressed_rows_say_the_same(seed: int, rows: int, columns: int) -> None:
    rng = np.random.default_rng(seed)
    A, b, q = rng.normal(size=(rows, columns)), rng.normal(size=rows), rng.normal(size=columns)
    R, top, constant = compress(A, b)
    assert len(R) <= max(columns, 1)
    np.testing.assert_allclose(np.sum((R @ q - top) ** 2) + constant, np.sum((A @ q - b) ** 2), rtol=1e-10)


@given(SEEDS, st.integers(1, 60), st.integers(1, 4))
def test_normal_distance_is_the_sum_over_beams(seed: int, m: int, degree: int) -> None:
    curve, t, normals, points, sigma = drawn(seed, m, degree)
    q = np.random.default_rng(seed + 1).normal(size=curve.control_points.shape)
    one = normal_distance(curve, t, normals, points, sigma)
    seen = q[one.first : one.first + one.A.shape[1] // 2].ravel()
    residuals = ((curve.with_control_points(q)(t) - points) * normals).sum(1) / sigma
    np.testing.assert_allclose(
        np.sum((one.A @ seen - one.b) ** 2) + one.constant, np.sum(residuals**2), rtol=1e-9, atol=1e-9
    )
    assert one.readings == m


@given(SEEDS, st.integers(1, 80))
def test_the_compiled_rows_agree_with_the_plain_ones(seed: int, m: int) -> None:
    curve, t, normals, points, sigma = drawn(seed, m)
    plain = normal_distance(curve, t, normals, points, sigma)
    first = np.clip(np.floor(t / 0.4).astype(np.int64), 0, len(curve.control_points) - 4)
    basis = np.take_along_axis(curve.basis(t), first[:, None] + np.arange(4), axis=1)
    right = (normals * points).sum(1)
    cuts, orders = np.array([0, m]), np.array([4])
    low, rows, columns = kernels.piece_sizes(cuts, orders, first)
    R, b, (constant,) = kernels.compressed_pieces(
        cuts, orders, first, basis, normals, right, 1.0 / sigma, low, rows, columns
    )
    A = R.reshape(rows[0], columns[0])
    assert low[0] == plain.first
    np.testing.assert_allclose(A.T @ A, plain.A.T @ plain.A, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(A.T @ b, plain.A.T @ plain.b, rtol=1e-9, atol=1e-7)
    total, plain_total = b @ b + constant, plain.b @ plain.b + plain.constant  # the split is free where rows vanish
    np.testing.assert_allclose(total, plain_total, rtol=1e-9, atol=1e-7)


def wall() -> tuple[BSpline, np.ndarray, np.ndarray]:
    """A straight wall along x, parameters on it, and its points."""
    curve = BSpline(3, uniform_knots(0.0, 0.4, 8), np.stack([0.4 * np.arange(8.0), np.full(8, 2.0)], -1))
    t = np.linspace(*curve.domain, 40)
    return curve, t, curve(t)


def test_a_straight_wall_says_nothing_along_itself_by_normal_distance() -> None:
    curve, t, points = wall()
    one = normal_distance(curve, t, curve.normals(t), points, np.full(40, 0.01))
    along = np.tile([1.0, 0.0], one.A.shape[1] // 2)
    np.testing.assert_allclose(one.A @ along, 0.0, atol=1e-9)
    across = np.tile([0.0, 1.0], one.A.shape[1] // 2)
    assert np.linalg.norm(one.A @ across) > 100.0


def test_a_straight_wall_is_claimed_to_be_known_along_itself_by_the_paper() -> None:
    curve, t, points = wall()
    one = chord_length(curve, t, points, FittingConfig())
    along = np.tile([1.0, 0.0], one.A.shape[1] // 2)
    assert np.linalg.norm(one.A @ along) > 10.0


def test_chord_length_gives_the_control_points_of_exact_data_back() -> None:
    curve, t, points = wall()
    one = chord_length(curve, t, points, FittingConfig())
    seen = curve.control_points[one.first : one.first + one.A.shape[1] // 2].ravel()
    np.testing.assert_allclose(one.A @ seen, one.b, atol=0.05)


def test_noise_across_a_wall_is_that_of_the_range_in_front_of_it_and_of_the_bearing_beside_it() -> None:
    config = FittingConfig(range_noise=0.02, bearing_noise=0.001)
    normals = np.array([[-1.0, 0.0], [-1.0, 0.0]])
    directions = np.array([[1.0, 0.0], [0.0, 1.0]])
    np.testing.assert_allclose(across_sigma(normals, directions, np.array([5.0, 5.0]), config), [0.02, 0.005])
