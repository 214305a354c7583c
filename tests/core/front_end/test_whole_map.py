"""Points that stand for the last key scans: spread over all that they saw, and over all ways that surfaces face."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.scan_matching import MatchingConfig, PointSet
from bspline_slam.front_end.whole_map import PlaceConfig, WholeMap, Window, evenly, facing, last_points


def corridor() -> PointSet:
    """Two walls of 20 m and a pier between them, with normals."""
    x = np.arange(-10.0, 10.0, 0.12)
    walls = [np.stack([x, np.full(len(x), y)], -1) for y in (-1.2, 1.2)]
    pier = np.stack([np.full(8, 3.0), np.linspace(0.4, 1.1, 8)], -1)
    normals = [np.tile([0.0, -y], (len(x), 1)) for y in (-1.0, 1.0)]
    return PointSet(np.concatenate([*walls, pier]), np.concatenate([*normals, np.tile([-1.0, 0.0], (8, 1))]))


@pytest.mark.parametrize("most", [1, 5, 40, 1000])
def test_no_kind_has_more_than_another_that_had_enough(most: int) -> None:
    kinds = np.random.default_rng(2).choice(4, 300, p=[0.6, 0.3, 0.08, 0.02])
    kept = evenly(kinds, most)
    had, has = np.bincount(kinds, minlength=4), np.bincount(kinds[kept], minlength=4)
    assert (np.diff(kept) > 0).all()
    assert len(kept) <= max(most, 4)
    short = has < has.max()
    np.testing.assert_array_equal(has[short], had[short])


def test_facing_does_not_ask_from_which_side() -> None:
    angle = np.linspace(0.0, 2 * np.pi, 25)[:-1] + 0.01
    normals = np.stack([np.cos(angle), np.sin(angle)], -1)
    np.testing.assert_array_equal(facing(normals, 6), facing(-normals, 6))
    assert set(facing(normals, 6).tolist()) == set(range(6))
    assert facing(np.zeros((1, 2)), 6).tolist() == [-1]


def test_a_pier_counts_as_much_as_the_walls_that_it_stands_between() -> None:
    keys, poses = [KeyScan(0, corridor(), 0.0)], np.zeros((1, 3))
    points = last_points(keys, poses, 0, PlaceConfig(points=14, facings=6))
    assert np.count_nonzero(points[:, 0] == 3.0) >= 6
    plain = last_points(keys, poses, 0, PlaceConfig(points=14))
    assert np.count_nonzero(plain[:, 0] == 3.0) <= 2


def test_only_places_inside_the_window_come_into_question() -> None:
    keys, poses = [KeyScan(0, corridor(), 0.0)], np.zeros((1, 3))
    config = PlaceConfig(points=60, facings=6, least_margin=0.05)
    known = WholeMap.of(keys, poses, [0], config, MatchingConfig())
    points = last_points(keys, poses, 0, config)
    found = known.only_place(points, config, Window(np.array([1.0, 0.5, 0.1]), 2.0, 0.3))
    assert found is not None
    np.testing.assert_allclose(se2.between(np.zeros(3), found), 0.0, atol=0.1)
    assert known.only_place(points, config, Window(np.array([6.0, 0.0, 0.0]), 3.0, 0.3)) is None
