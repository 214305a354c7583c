"""Every residual of the graph against central differences of itself, and the identities that define it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bspline_slam import se2
from bspline_slam.graph import PoseFactor, PosePrior, ShapePrior, SplineFactor

STEP = 1e-5


def reals(*shape: int) -> st.SearchStrategy[np.ndarray]:
    return arrays(float, shape, elements=st.floats(-3.0, 3.0, width=32))


def central_difference(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """Columns ∂f/∂x_k, of x flattened."""
    columns = []
    for k in range(at.size):
        step = np.zeros(at.size)
        step[k] = STEP
        step = step.reshape(at.shape)
        columns.append((function(at + step) - function(at - step)) / (2 * STEP))
    return np.column_stack(columns)


@given(reals(5, 8), reals(5), reals(3), reals(4, 2))
def test_spline_factor_jacobians(A, b, pose, control_points):
    factor = SplineFactor(0, 0, A, b)
    by_pose, by_points = factor.jacobians(pose, control_points)
    np.testing.assert_allclose(
        by_pose, central_difference(lambda x: factor.residual(x, control_points), pose), atol=1e-6
    )
    np.testing.assert_allclose(
        by_points, central_difference(lambda c: factor.residual(pose, c), control_points), atol=1e-6
    )


@given(reals(3), reals(3), reals(3), reals(3, 3))
def test_pose_factor_jacobians(pose_i, pose_j, error, sqrt_information):
    measured = se2.compose(se2.between(pose_i, pose_j), 0.5 * error)
    factor = PoseFactor(0, 1, measured, sqrt_information)
    by_i, by_j = factor.jacobians(pose_i, pose_j)
    np.testing.assert_allclose(by_i, central_difference(lambda x: factor.residual(x, pose_j), pose_i), atol=1e-6)
    np.testing.assert_allclose(by_j, central_difference(lambda x: factor.residual(pose_i, x), pose_j), atol=1e-6)


@given(reals(3), reals(3), reals(3, 3))
def test_prior_jacobian_is_its_root_of_information(mean, error, sqrt_information):
    prior = PosePrior(0, mean, sqrt_information)
    difference = central_difference(prior.residual, mean + error)
    np.testing.assert_allclose(sqrt_information, difference, atol=1e-6)


@given(reals(4, 6), reals(4), reals(3, 2))
def test_shape_prior_jacobian_is_its_matrix(A, b, control_points):
    difference = central_difference(ShapePrior(0, A, b).residual, control_points)
    np.testing.assert_allclose(A, difference, atol=1e-6)


@given(reals(6, 8), reals(3), reals(3), reals(4, 2))
def test_residuals_do_not_change_when_the_world_is_moved(A, rigid, pose, control_points):
    factor, edge = SplineFactor(0, 0, A, np.zeros(6)), PoseFactor(0, 1, np.array([1.0, 0.2, 0.1]), np.eye(3))
    other = se2.compose(pose, np.array([0.5, 0.5, 0.3]))
    moved, other_moved = se2.compose(rigid, pose), se2.compose(rigid, other)
    np.testing.assert_allclose(
        factor.residual(moved, se2.transform(rigid, control_points)), factor.residual(pose, control_points), atol=1e-9
    )
    np.testing.assert_allclose(edge.residual(moved, other_moved), edge.residual(pose, other), atol=1e-9)


@given(reals(3), st.integers(-3, 3))
def test_whole_turns_are_no_error(pose, turns):
    whole = np.array([0.0, 0.0, 2 * np.pi * turns])
    edge = PoseFactor(0, 1, np.array([1.0, 0.0, 0.4]), np.eye(3))
    ahead = se2.compose(pose, edge.measured)
    np.testing.assert_allclose(edge.residual(pose, ahead + whole), 0.0, atol=1e-9)
    np.testing.assert_allclose(PosePrior(0, pose, np.eye(3)).residual(pose + whole), 0.0, atol=1e-9)
