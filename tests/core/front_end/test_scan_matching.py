"""Scan matching: search finds what refinement alone cannot, and the whole is equivariant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.front_end.icp import IcpConfig, align, icp_map
from bspline_slam.front_end.scan_matching import (
    MatchingConfig,
    PointSet,
    find,
    find_with_icp,
    gather,
    point_set,
    refine,
    search,
    settle,
    surroundings,
)
from bspline_slam.segmentation import SegmentationConfig
from core.rooms import ROOM, room_scan

CONFIG = MatchingConfig()
HERE = np.array([2.0, 1.8, 0.6])
OFFSETS = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.17, 0.17)).map(np.array)


def seen_from(pose: np.ndarray, seed: int) -> PointSet:
    return point_set(room_scan(pose, np.random.default_rng(seed)), CONFIG, SegmentationConfig())


MAP_POSES = np.array([[2.0, 1.5, 0.0], [1.5, 1.2, 2.0], [3.0, 1.3, -2.0]])
MAP = gather([seen_from(pose, k) for k, pose in enumerate(MAP_POSES)], MAP_POSES)
PLACE = surroundings(MAP, CONFIG)


def off(found: np.ndarray, truth: np.ndarray = HERE) -> tuple[float, float]:
    d = se2.between(truth, found)
    return float(np.hypot(d[0], d[1])), float(abs(d[2]))


def test_normals_point_at_the_sensor_and_across_walls() -> None:
    points = seen_from(HERE, 9)
    known = np.abs(points.normals).sum(1) > 0
    assert known.mean() > 0.9
    towards = np.array([0.1, 0.0]) - points.points
    assert ((points.normals * towards).sum(1)[known] >= 0).all()
    world = se2.rotate(HERE, points.normals[known])
    assert (np.abs(world).max(1) > 0.97).mean() > 0.85


@settings(max_examples=25)
@given(OFFSETS, st.integers(10, 20))
def test_search_and_settle_find_the_pose_from_anywhere_in_the_window(offset: np.ndarray, seed: int) -> None:
    scan = seen_from(HERE, seed)
    found, score = search(PLACE.field, scan, se2.compose(HERE, offset), CONFIG, 0.5, 0.25)
    distance, turn = off(found)
    assert score > 0.6
    assert distance < 0.08
    assert turn < 0.02
    match = settle(PLACE, scan, found, score, CONFIG)
    distance, turn = off(match.pose)
    assert distance < 0.01
    assert turn < 0.005
    assert match.inliers > 0.8


def test_block_bounds_never_hide_the_best_pose() -> None:
    """Branch and bound gives the same pose as blocks of one cell, which bound nothing."""
    scan = seen_from(HERE, 5)
    guess = se2.compose(HERE, np.array([0.2, -0.15, 0.08]))
    plain = surroundings(MAP, CONFIG, block=1)
    found, score = search(PLACE.field, scan, guess, CONFIG, 0.4, 0.2)
    expected, expected_score = search(plain.field, scan, guess, CONFIG, 0.4, 0.2)
    np.testing.assert_allclose(found, expected)
    assert score == pytest.approx(expected_score)


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(-3, 3))
def test_refinement_moves_with_the_world(x: float, y: float, turn: float) -> None:
    move = np.array([x, y, turn])
    scan = seen_from(HERE, 6)
    guess = se2.compose(HERE, np.array([0.03, -0.02, 0.01]))
    moved_map = gather([seen_from(p, k) for k, p in enumerate(MAP_POSES)], se2.compose(move, MAP_POSES))
    here = refine(MAP, scan, guess, CONFIG).pose
    there = refine(moved_map, scan, se2.compose(move, guess), CONFIG).pose
    np.testing.assert_allclose(se2.between(se2.compose(move, here), there), 0.0, atol=2e-3)


def test_stated_information_matches_the_scatter_of_many_scans() -> None:
    """Widened by the shared noise of the map, but of the right size: within a factor of three in every direction."""
    matches = [refine(MAP, seen_from(HERE, seed), HERE, CONFIG) for seed in range(100, 160)]
    scatter = np.cov(np.array([se2.between(HERE, m.pose) for m in matches]).T)
    stated = np.linalg.inv(matches[0].information)
    ratio = np.sqrt(np.diag(scatter) / np.diag(stated))
    assert ((ratio > 1 / 3) & (ratio < 3)).all()


def test_a_corridor_leaves_the_pose_along_it_to_the_prior() -> None:
    walls = np.array([[[-30.0, -1.0], [30.0, -1.0]], [[-30.0, 1.0], [30.0, 1.0]]])
    rng = np.random.default_rng(2)
    scan = room_scan(np.zeros(3), rng, walls=walls)
    points = point_set(scan, CONFIG, SegmentationConfig())
    match = refine(gather([points], np.zeros((1, 3))), points, np.zeros(3), CONFIG)
    assert match.information[0, 0] < 1e-2 * match.information[1, 1]


@pytest.mark.parametrize("shift", [0.05, 0.15])
def test_icp_closes_in_on_the_pose(shift: float) -> None:
    scan = seen_from(HERE, 7)
    guess = se2.compose(HERE, np.array([shift, -shift, 0.3 * shift]))
    config = IcpConfig()
    found = align(icp_map(MAP.points, config), scan.points, guess, config)
    assert off(found)[0] < 0.5 * off(guess)[0]


def test_icp_on_a_single_wall_does_not_leave_the_plane() -> None:
    wall = np.stack([np.linspace(0, 3, 60), np.ones(60)], -1)
    config = IcpConfig()
    found = align(icp_map(wall, config), wall, np.array([0.0, 0.02, 0.0]), config)
    assert np.isfinite(found).all()
    assert abs(found[1]) < 0.03


def test_a_scan_found_among_others_in_one_call_lies_where_search_and_settle_put_it() -> None:
    sets, scan = [seen_from(pose, k) for k, pose in enumerate(MAP_POSES)], seen_from(HERE, 7)
    guess = se2.compose(HERE, np.array([0.25, -0.2, 0.1]))
    found = find(sets, MAP_POSES, scan, guess, CONFIG, 0.4, 0.2)
    start, score = search(PLACE.field, scan, guess, CONFIG, 0.4, 0.2)
    wanted = settle(PLACE, scan, start, score, CONFIG)
    np.testing.assert_allclose(se2.between(found.pose, wanted.pose), 0.0, atol=2e-3)
    assert found.score == wanted.score
    assert off(found.pose)[0] < 0.01


def test_a_scan_without_beams_matches_nothing() -> None:
    nothing = PointSet(np.zeros((0, 2)), np.zeros((0, 2)))
    found, score = search(PLACE.field, nothing, HERE, CONFIG, 0.4, 0.2)
    assert score == 0.0
    assert settle(PLACE, nothing, found, score, CONFIG).inliers == 0.0
    assert find([nothing], HERE[None], seen_from(HERE, 7), HERE, CONFIG, 0.4, 0.2).score == 0.0
    assert find([seen_from(HERE, 7)], HERE[None], nothing, HERE, CONFIG, 0.4, 0.2).score == 0.0


SPARSE = 136
"""Beams of a laser that meets the far walls of its room half a metre apart."""


def seen_sparsely(pose: np.ndarray, seed: int) -> PointSet:
    scan = room_scan(pose, np.random.default_rng(seed), walls=5.0 * ROOM, beams=SPARSE)
    return point_set(replace(scan, range_max=60.0), CONFIG, SegmentationConfig())


def test_walls_go_on_between_beams_that_meet_them_far_apart() -> None:
    points = seen_sparsely(np.array([9.0, 7.0, 0.4]), 1)
    filled = gather([points], np.zeros((1, 3))).points
    assert len(filled) > 2 * len(points.points)
    starts = 5.0 * ROOM[:, 0]
    along = 5.0 * ROOM[:, 1] - starts
    unit = along / np.linalg.norm(along, axis=1)[:, None]
    off_start = se2.transform(np.array([9.0, 7.0, 0.4]), filled)[:, None] - starts
    across = np.abs(off_start[..., 0] * unit[:, 1] - off_start[..., 1] * unit[:, 0])
    assert across.min(axis=1).max() < 0.06


def test_a_scan_of_far_walls_is_not_drawn_to_where_beams_ended_before() -> None:
    before, after = np.array([9.0, 7.0, 0.4]), np.array([9.11, 7.05, 0.4])
    place = surroundings(gather([seen_sparsely(before, 1)], before[None]), CONFIG)
    found, score = search(place.field, seen_sparsely(after, 2), before, CONFIG, CONFIG.reach, CONFIG.turn)
    distance, turn = off(found, after)
    assert distance < 0.08
    assert turn < 0.01
    assert score > 0.7


def test_nothing_is_made_up_between_surfaces() -> None:
    """Two walls in line with a door between them, and a corner."""
    wall = np.column_stack([np.arange(0.0, 3.0, 0.3), np.full(10, 2.0)])
    beyond = wall + np.array([4.2, 0.0])
    side = np.column_stack([np.full(10, 7.4), 1.5 - np.arange(0.0, 3.0, 0.3)])
    points = np.concatenate([wall, beyond, side])
    normals = np.concatenate([np.tile([0.0, -1.0], (20, 1)), np.tile([-1.0, 0.0], (10, 1))])
    filled = gather([PointSet(points, normals)], np.zeros((1, 3))).points
    along = filled[filled[:, 1] == 2.0][:, 0]
    assert not ((along > 2.71) & (along < 4.19)).any()
    assert np.diff(np.sort(along[(along > 0.29) & (along < 2.41)])).max() < 0.11
    assert not ((filled[:, 0] > 6.91) & (filled[:, 0] < 7.39)).any()


CORRIDOR = np.array([[[-60.0, 0.0], [45.0, 0.0]], [[-60.0, 2.0], [45.0, 2.0]], [[45.0, 0.0], [45.0, 2.0]]])
"""Bare walls, whose one end is far away and whose other is out of sight."""


def in_corridor(x: float, seed: int, range_max: float) -> PointSet:
    scan = room_scan(np.array([x, 1.0, 0.0]), np.random.default_rng(seed), walls=CORRIDOR, beams=1081)
    return point_set(replace(scan, range_max=range_max), CONFIG, SegmentationConfig())


@pytest.mark.parametrize("seed", range(4))
def test_a_bare_wall_says_nothing_of_the_way_along_it(seed: int) -> None:
    poses = np.array([[0.0, 1.0, 0.0], [0.5, 1.0, 0.0]])
    sets, scan = [in_corridor(x, 10 * seed + k, 8.0) for k, x in enumerate(poses[:, 0])], in_corridor(0.3, seed, 8.0)
    guess = np.array([0.35, 1.02, 0.01])
    for match in (
        refine(gather(sets, poses), scan, guess, CONFIG),
        find(sets, poses, scan, guess, CONFIG, 0.4, 0.2),
        find_with_icp(sets, poses, scan, guess, CONFIG, 0.4, 0.2),
    ):
        assert abs(match.pose[1] - 1.0) < 0.01
        assert match.information[0, 0] < 1.0 / 0.3**2
        assert match.information[1, 1] > 1.0 / 0.005**2


def test_a_room_says_where_a_scan_is_in_all_directions() -> None:
    scan = seen_from(HERE, 21)
    match = find([seen_from(pose, k) for k, pose in enumerate(MAP_POSES)], MAP_POSES, scan, HERE, CONFIG, 0.4, 0.2)
    assert np.linalg.eigvalsh(match.information[:2, :2]).min() > 1.0 / 0.005**2


def test_far_beams_count_where_near_ones_leave_a_way_open() -> None:
    assert in_corridor(0.0, 0, 80.0).points[:, 0].max() > 44.0
    walled = np.concatenate([CORRIDOR, [[[2.0, 0.0], [2.0, 0.9]]]])
    scan = room_scan(np.array([0.0, 1.0, 0.0]), np.random.default_rng(1), walls=walled, beams=1081)
    points = point_set(replace(scan, range_max=80.0), CONFIG, SegmentationConfig()).points
    assert np.hypot(*points.T).max() <= CONFIG.largest_range + 0.1
