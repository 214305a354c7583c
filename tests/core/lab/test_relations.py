"""Errors of relations: zero for the truth, known for a known disturbance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.lab.relations import RelationErrors, Relations


def circle(count: int = 50) -> Trajectory:
    angle = np.linspace(0.0, 2 * np.pi, count)
    poses = np.stack([5 * np.cos(angle), 5 * np.sin(angle), se2.wrap(angle + np.pi / 2)], -1)
    return Trajectory(np.arange(count) * 0.1, poses)


def true_relations(trajectory: Trajectory, rng: np.random.Generator, count: int = 20) -> Relations:
    ends = rng.integers(len(trajectory), size=(count, 2))
    measured = se2.between(trajectory.poses[ends[:, 0]], trajectory.poses[ends[:, 1]])
    return Relations(trajectory.stamps[ends], measured)


@given(st.integers(0, 2**32 - 1))
def test_the_truth_has_no_error_in_whatever_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = circle()
    moved = Trajectory(truth.stamps, se2.compose(rng.normal(size=3), truth.poses))
    errors = RelationErrors.from_trajectory(moved, true_relations(truth, rng))
    assert errors.scored.all()
    assert not errors.interpolated.any()
    np.testing.assert_allclose(errors.translation, 0.0, atol=1e-9)
    np.testing.assert_allclose(errors.translation_with_lever_arm, 0.0, atol=1e-9)
    np.testing.assert_allclose(errors.rotation, 0.0, atol=1e-9)


def test_both_definitions_on_a_known_error() -> None:
    trajectory = Trajectory(np.array([0.0, 1.0]), np.array([[0.0, 0.0, 0.0], [10.0, 0.3, 0.02]]))
    relations = Relations(np.array([[0.0, 1.0]]), np.array([[10.0, 0.0, 0.0]]))
    errors = RelationErrors.from_trajectory(trajectory, relations)
    np.testing.assert_allclose(errors.translation, 0.3)
    np.testing.assert_allclose(errors.rotation, 0.02)
    lever_arm = np.hypot(10.0 - 10.0 * np.cos(0.02), 0.3 - 10.0 * np.sin(0.02))
    np.testing.assert_allclose(errors.translation_with_lever_arm, lever_arm)


def test_ends_between_records_are_interpolated_and_ends_outside_are_not_scored() -> None:
    trajectory = Trajectory(np.array([0.0, 1.0, 2.0]), np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]]))
    ends = np.array([[0.0, 2.0], [0.5, 1.0], [0.0, 2.5], [-1.0, 1.0]])
    measured = np.array([[2.0, 0, 0], [0.4, 0, 0], [2.5, 0, 0], [2.0, 0, 0]])
    errors = RelationErrors.from_trajectory(trajectory, Relations(ends, measured))
    np.testing.assert_array_equal(errors.scored, [True, True, False, False])
    np.testing.assert_array_equal(errors.interpolated, [False, True, False, False])
    np.testing.assert_allclose(errors.translation, [0.0, 0.1], atol=1e-12)


def test_a_half_turn_more_or_less_is_a_small_error() -> None:
    trajectory = Trajectory(np.array([0.0, 1.0]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.pi - 0.01]]))
    relations = Relations(np.array([[0.0, 1.0]]), np.array([[0.0, 0.0, -np.pi + 0.01]]))
    np.testing.assert_allclose(RelationErrors.from_trajectory(trajectory, relations).rotation, 0.02)


def test_a_file_of_relations(tmp_path: Path) -> None:
    path = tmp_path / "a.relations"
    path.write_text("# t1 t2 x y z roll pitch yaw\n976052905.167303 976052911.885496 -0.05 -0.12 0 0 0 -1.68\n\n")
    relations = Relations.from_file(path)
    assert len(relations) == 1
    np.testing.assert_array_equal(relations.ends, [[976052905.167303, 976052911.885496]])
    np.testing.assert_array_equal(relations.measured, [[-0.05, -0.12, -1.68]])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [("", "holds no relations"), ("1 2 3\n", "a.relations:1: a relation is"), ("a b c d e f g h\n", "eight numbers")],
)
def test_files_that_hold_no_relations(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "a.relations").write_text(text)
    with pytest.raises(LogError, match=sentence):
        Relations.from_file(tmp_path / "a.relations")


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="not a readable file of relations"):
        Relations.from_file(tmp_path / "gone.relations")
