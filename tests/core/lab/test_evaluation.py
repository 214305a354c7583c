"""Figures, absolute and relative errors of trajectories."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bspline_slam import se2
from bspline_slam.errors import SplineSlamError
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.lab.evaluation import Figures, TrajectoryErrors, alignment, pairs_along

POSES = arrays(float, 3, elements=st.floats(-10.0, 10.0))


def square(count: int = 81) -> Trajectory:
    """Round a square of 4 m, 0.2 m apart."""
    way = np.arange(count) * 0.2
    side, along = (way // 4).astype(int) % 4, way % 4
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    heading = side * np.pi / 2
    positions = corners[side] + along[:, None] * np.stack([np.cos(heading), np.sin(heading)], -1)
    return Trajectory(np.arange(count) * 0.5, np.column_stack([positions, se2.wrap(heading)]))


def test_figures_of_a_small_sample() -> None:
    figures = Figures.of(np.array([1.0, 2.0, 3.0]))
    assert (figures.mean, figures.maximum) == (2.0, 3.0)
    np.testing.assert_allclose([figures.std, figures.rms], [np.sqrt(2 / 3), np.sqrt(14 / 3)])


@given(POSES)
def test_a_trajectory_in_another_frame_has_no_error(frame: np.ndarray) -> None:
    reference = square()
    errors = TrajectoryErrors.from_trajectories(
        Trajectory(reference.stamps, se2.compose(frame, reference.poses)), reference
    )
    assert (errors.compared, errors.left_out) == (81, 0)
    for values in (errors.absolute_translation, errors.absolute_rotation):
        np.testing.assert_allclose(values, 0.0, atol=1e-8)
    for values in (errors.relative_translation, errors.relative_rotation):
        np.testing.assert_allclose(values, 0.0, atol=1e-8)


@given(POSES, arrays(float, (6, 2), elements=st.floats(-5.0, 5.0)))
def test_no_small_move_improves_the_alignment(frame: np.ndarray, points: np.ndarray) -> None:
    targets = se2.transform(frame, points) + 0.1 * np.sin(np.arange(12.0)).reshape(6, 2)
    best = alignment(points, targets)

    def cost(pose: np.ndarray) -> float:
        return float(np.sum((se2.transform(pose, points) - targets) ** 2))

    for axis in range(3):
        for sign in (-1e-3, 1e-3):
            moved = best.copy()
            moved[axis] += sign
            assert cost(moved) >= cost(best) - 1e-9


def test_odometry_too_long_by_a_hundredth_shows_in_the_relative_error() -> None:
    reference = Trajectory(np.arange(51.0), np.column_stack([0.1 * np.arange(51.0), np.zeros((51, 2))]))
    longer = Trajectory(reference.stamps, reference.poses * [1.01, 1.0, 1.0])
    errors = TrajectoryErrors.from_trajectories(longer, reference, distance=1.0)
    np.testing.assert_allclose(errors.relative_translation, 0.01, atol=1.5e-3)
    np.testing.assert_allclose(errors.absolute_translation.max(), 0.025, atol=1e-9)


def test_stamps_of_another_clock_are_refused() -> None:
    reference = square()
    late = Trajectory(reference.stamps + 1e6, reference.poses)
    with pytest.raises(SplineSlamError, match="covers 0 of the 81 stamps of the reference: are both on one clock"):
        TrajectoryErrors.from_trajectories(late, reference)


def test_what_the_trajectory_does_not_cover_is_left_out() -> None:
    reference = square()
    first_half = Trajectory(reference.stamps[:41], reference.poses[:41])
    errors = TrajectoryErrors.from_trajectories(first_half, reference)
    assert (errors.compared, errors.left_out) == (41, 40)


@given(arrays(float, (20, 3), elements=st.floats(-1.0, 1.0)), st.floats(0.1, 3.0))
def test_pairs_are_the_first_ones_far_enough_apart(poses: np.ndarray, distance: float) -> None:
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1))])
    first, second = pairs_along(poses, distance)
    assert (path[second] >= path[first] + distance).all()
    assert (path[second - 1] < path[first] + distance).all()
    assert len(first) == np.count_nonzero(path + distance <= path[-1])
