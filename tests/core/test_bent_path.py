"""A bent path leads through the poses given, and shares what they ask of it."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.bent_path import bent_through

STRAIGHT = np.stack([np.arange(5.0), np.zeros(5), np.zeros(5)], -1)


def test_what_lies_between_shares_the_difference_evenly() -> None:
    bent = bent_through(STRAIGHT, np.array([0, 4]), np.array([[0.0, 0.0, 0.0], [4.0, 0.4, 0.0]]))
    np.testing.assert_allclose(bent[:, 1], [0.0, 0.1, 0.2, 0.3, 0.4], atol=1e-12)
    np.testing.assert_allclose(bent[:, 0], np.arange(5.0), atol=1e-12)


def test_the_difference_is_shared_by_the_way_gone() -> None:
    way = np.array([0.0, 3.0, 3.0, 3.0, 4.0])
    bent = bent_through(STRAIGHT, np.array([0, 4]), np.array([[0.0, 0.0, 0.0], [4.0, 0.4, 0.0]]), way)
    np.testing.assert_allclose(bent[:, 1], [0.0, 0.3, 0.3, 0.3, 0.4], atol=1e-12)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_it_leads_through_its_poses_and_hangs_on_them_beyond(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    path = rng.normal(size=(12, 3))
    places, poses = np.sort(rng.choice(12, count, replace=False)), rng.normal(size=(count, 3))
    bent = bent_through(path, places, poses)
    np.testing.assert_allclose(bent[places], se2.compose(poses, np.zeros(3)), atol=1e-9)
    for end, outer in ((0, slice(None, places[0])), (-1, slice(places[-1], None))):
        told, was = se2.between(poses[end], bent[outer]), se2.between(path[places[end]], path[outer])
        np.testing.assert_allclose(told[:, :2], was[:, :2], atol=1e-9)
        np.testing.assert_allclose(se2.wrap(told[:, 2] - was[:, 2]), 0.0, atol=1e-9)


def test_a_path_without_poses_stays_as_it_is() -> None:
    assert bent_through(STRAIGHT, np.zeros(0, dtype=np.int64), np.zeros((0, 3))) is STRAIGHT
