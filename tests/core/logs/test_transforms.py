"""Frames: rotations are rotations, chains multiply, and the plane is what is left of space."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.logs.transforms import FrameTree, in_space, planar, planar_mounting, rotation_of

NUMBERS = st.floats(-10, 10)
QUATERNIONS = st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS).filter(lambda q: sum(n * n for n in q) > 1e-3)
POSES = st.tuples(NUMBERS, NUMBERS, st.floats(-3, 3))


def flat(pose: tuple[float, float, float]) -> np.ndarray:
    """A pose of the plane as a transform in space."""
    return in_space((pose[0], pose[1], 0.0), rotation_of(0.0, 0.0, np.sin(pose[2] / 2), np.cos(pose[2] / 2)))


@given(QUATERNIONS)
def test_rotations_are_orthogonal(quaternion: tuple[float, float, float, float]) -> None:
    rotation = rotation_of(*quaternion)
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9) and np.linalg.det(rotation) > 0


def test_zero_quaternion_is_no_rotation() -> None:
    assert np.array_equal(rotation_of(0.0, 0.0, 0.0, 0.0), np.eye(3))


@given(POSES, POSES)
def test_chains_compose_like_poses(a: tuple[float, float, float], b: tuple[float, float, float]) -> None:
    frames = FrameTree()
    frames.add("base", "plate", 0.0, 0.0, flat(a))
    frames.add("/plate", "/laser", 0.0, 0.0, flat(b))
    mounting = frames.mounting("laser", "base")
    expected = se2.compose(np.array(a), np.array(b))
    pose, upside_down = planar_mounting(mounting)
    assert np.allclose(pose[:2], expected[:2], atol=1e-9)
    assert np.isclose(np.cos(pose[2] - expected[2]), 1.0) and not upside_down


def test_frames_that_are_not_joined() -> None:
    frames = FrameTree()
    frames.add("base", "laser", 0.0, 0.0, np.eye(4))
    assert frames.joins("laser", "/base") and not frames.joins("laser", "elsewhere")
    assert frames.odometry_edge("laser") is None


def test_a_ring_of_frames_ends() -> None:
    frames = FrameTree()
    frames.add("a", "b", 0.0, 0.0, np.eye(4))
    frames.add("b", "a", 0.0, 0.0, np.eye(4))
    assert frames.above("a") == ["a", "b"]


def test_the_robot_is_the_last_frame_that_stands_still() -> None:
    frames = FrameTree()
    frames.add("turtle", "laser", 0.0, 0.0, np.eye(4))
    for i in range(3):
        frames.add("odom", "turtle", i, i, flat((i, 0, 0)))
    assert frames.base_of("laser") == "turtle"
    moving = frames.odometry_edge("laser")
    assert moving is not None and moving[0] == "turtle"
    assert [planar(transform)[0] for transform in moving[1].transforms] == [0, 1, 2]


def test_a_frame_keeps_its_first_parent() -> None:
    frames = FrameTree()
    frames.add("odom", "base", 0.0, 0.0, np.eye(4))
    frames.add("map", "base", 0.0, 0.0, flat((5, 5, 0)))
    assert frames.above("base") == ["base", "odom"] and len(frames.edges["base"].transforms) == 1
