"""SE(2) as a group that acts on the plane."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bspline_slam import se2

NUMBERS = st.floats(-100.0, 100.0, allow_subnormal=False)
POSES = arrays(float, 3, elements=NUMBERS)
POINTS = arrays(float, (5, 2), elements=NUMBERS)
FRACTIONS = st.floats(0.0, 1.0)


def assert_same_pose(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(a[..., :2], b[..., :2], atol=1e-9)
    np.testing.assert_allclose(np.exp(1j * a[..., 2]), np.exp(1j * b[..., 2]), atol=1e-9)


@given(st.floats(-1000.0, 1000.0))
def test_wrapped_angles_lie_within_half_a_turn_and_point_the_same_way(angle: float) -> None:
    wrapped = float(se2.wrap(angle))
    assert -np.pi <= wrapped <= np.pi
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angle), atol=1e-9)


def test_a_half_turn_stays_positive() -> None:
    np.testing.assert_array_equal(se2.wrap(np.array([np.pi, -np.pi])), [np.pi, np.pi])


@given(POSES, POSES, POSES)
def test_composition_is_associative(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    assert_same_pose(se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c)))


@given(POSES)
def test_identity_and_inverse(a: np.ndarray) -> None:
    assert_same_pose(se2.compose(a, se2.IDENTITY), a)
    assert_same_pose(se2.compose(se2.IDENTITY, a), a)
    assert_same_pose(se2.compose(a, se2.inverse(a)), se2.IDENTITY)
    assert_same_pose(se2.compose(se2.inverse(a), a), se2.IDENTITY)


@given(POSES, POSES, POSES)
def test_relative_poses_do_not_depend_on_the_frame(world: np.ndarray, a: np.ndarray, b: np.ndarray) -> None:
    assert_same_pose(se2.between(se2.compose(world, a), se2.compose(world, b)), se2.between(a, b))


@given(POSES, POSES)
def test_between_undoes_compose(a: np.ndarray, b: np.ndarray) -> None:
    assert_same_pose(se2.between(a, se2.compose(a, b)), b)


@given(POSES, POSES, POINTS)
def test_transforming_is_an_action_of_the_group(a: np.ndarray, b: np.ndarray, points: np.ndarray) -> None:
    np.testing.assert_allclose(
        se2.transform(se2.compose(a, b), points), se2.transform(a, se2.transform(b, points)), atol=1e-9
    )


@given(POSES, POINTS)
def test_transforming_keeps_distances_and_agrees_with_the_rotation_matrix(a: np.ndarray, points: np.ndarray) -> None:
    moved = se2.transform(a, points)
    np.testing.assert_allclose(moved, points @ se2.rotation(a[2]).T + a[:2], atol=1e-9)
    np.testing.assert_allclose(
        np.linalg.norm(moved - moved[0], axis=1), np.linalg.norm(points - points[0], axis=1), atol=1e-9
    )


@given(POSES, POINTS)
def test_directions_turn_but_do_not_move(a: np.ndarray, vectors: np.ndarray) -> None:
    before = a.copy()
    np.testing.assert_allclose(se2.rotate(a, vectors), se2.transform(a, vectors) - a[:2], atol=1e-9)
    np.testing.assert_array_equal(a, before)


@given(st.lists(POSES, min_size=1, max_size=5), POSES)
def test_a_stack_of_poses_is_treated_one_by_one(rows: list[np.ndarray], b: np.ndarray) -> None:
    stack = np.array(rows)
    composed = np.array([se2.compose(row, b) for row in rows])
    inverted = np.array([se2.inverse(row) for row in rows])
    np.testing.assert_allclose(se2.between(composed, se2.compose(stack, b)), 0.0, atol=1e-9)
    np.testing.assert_allclose(se2.between(inverted, se2.inverse(stack)), 0.0, atol=1e-9)


@given(POSES, POSES, FRACTIONS)
def test_interpolation_starts_and_ends_right_and_takes_the_short_way(
    a: np.ndarray, b: np.ndarray, fraction: float
) -> None:
    assert_same_pose(se2.interpolate(a, b, 0.0), a)
    assert_same_pose(se2.interpolate(a, b, 1.0), b)
    middle = se2.interpolate(a, b, fraction)
    np.testing.assert_allclose(middle[:2], (1 - fraction) * a[:2] + fraction * b[:2], atol=1e-9)
    turned = a[2] + fraction * se2.wrap(b[2] - a[2])
    np.testing.assert_allclose(np.exp(1j * middle[2]), np.exp(1j * turned), atol=1e-9)


@given(POSES, POSES, arrays(float, 4, elements=FRACTIONS))
def test_several_fractions_at_once(a: np.ndarray, b: np.ndarray, fractions: np.ndarray) -> None:
    np.testing.assert_array_equal(
        se2.interpolate(a, b, fractions), [se2.interpolate(a, b, float(fraction)) for fraction in fractions]
    )
