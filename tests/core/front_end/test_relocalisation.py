"""A lost robot is found again where its scans fit one place of the map, and nowhere when they fit several or none."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closure import LoopConfig, Proposal
from bspline_slam.front_end.motion import MotionConfig
from bspline_slam.front_end.relocalisation import RelocalisationConfig, Relocaliser
from bspline_slam.front_end.scan_matching import MatchingConfig, point_set
from bspline_slam.front_end.tracking import Tracker
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.kernels.anywhere import pyramid, search_anywhere
from bspline_slam.segmentation import SegmentationConfig
from core.rooms import ROOM, loop_path, room_scan

AROUND = np.concatenate([ROOM[:6], ROOM[6:] - [0.4, 0.4]])
SQUARE = np.array(
    [[[0.0, 0.0], [5.0, 0.0]], [[5.0, 0.0], [5.0, 5.0]], [[5.0, 5.0], [0.0, 5.0]], [[0.0, 5.0], [0.0, 0.0]]]
)


def seen(path: np.ndarray, walls: np.ndarray, seed: int, travel: float = 0.0) -> list[KeyScan]:
    rng, config, segmentation = np.random.default_rng(seed), MatchingConfig(), SegmentationConfig()
    scans = [room_scan(pose, rng, index=k, walls=walls) for k, pose in enumerate(path)]
    return [KeyScan(k, point_set(scan, config, segmentation), travel + 0.5 * k) for k, scan in enumerate(scans)]


def looked_for(known: np.ndarray, piece: np.ndarray, walls: np.ndarray, strange: np.ndarray) -> tuple[Proposal, ...]:
    """What is found of a piece that is drawn `strange`ly far from where it is."""
    keys = [*seen(known, walls, 1), *seen(piece, strange, 2, travel=20.0)]
    away = np.array([4.0, -3.0, 2.0])
    poses = np.concatenate([known, se2.compose(away, piece)])
    seeker = Relocaliser(len(known), RelocalisationConfig(), MatchingConfig(), TrackingConfig(), LoopConfig())
    for k in range(len(known) + 1, len(keys) + 1):
        found = seeker.look(keys[:k], poses[:k], [])
        if found:
            assert seeker.settled
            return found
    return ()


def test_a_piece_is_found_where_it_is() -> None:
    path = loop_path(30)
    known, piece = path[:24], path[8:18] + np.array([0.1, 0.05, 0.02])
    found = looked_for(known, piece, AROUND, AROUND)
    assert len(found) == 2
    for proposal in found:
        off = se2.between(piece[proposal.j - len(known)], se2.compose(known[proposal.i], proposal.closure.measured))
        assert np.hypot(off[0], off[1]) < 0.05
        assert abs(off[2]) < 0.02
        assert "found again" in proposal.closure.reason


def test_what_looks_alike_from_several_places_is_not_decided() -> None:
    path = np.array([[2.5 + np.cos(a), 2.5 + np.sin(a), a] for a in np.linspace(0.0, 6.0, 20)])
    assert looked_for(path, path[4:12], SQUARE, SQUARE) == ()


def test_what_is_not_on_the_map_is_not_found_there() -> None:
    path = loop_path(30)
    assert looked_for(path[:24], path[8:18], AROUND, 1.7 * SQUARE[:, ::-1] - [2.0, 1.0]) == ()


def test_a_level_of_the_pyramid_bounds_the_squares_below() -> None:
    field = np.random.default_rng(3).random((23, 17)).astype(np.float32)
    levels = pyramid(field, 4)
    for level in range(4):
        size = 2**level
        for i, j in ((0, 0), (5, 9), (19, 3), (22, 16)):
            assert levels[level, i, j] == field[i : i + size, j : j + size].max()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("reach", [np.inf, 0.85])
def test_branch_and_bound_finds_what_trying_everything_finds(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    field, points = rng.random((30, 26)).astype(np.float32), rng.uniform(-0.6, 0.6, (8, 2))
    bounds, turns, middle = pyramid(field, 4), 12, np.array([1.1, 1.3, 0.0])
    args = (bounds, np.zeros(2), 0.1, points, 2 * np.pi * np.arange(turns) / turns, middle, reach)
    x, y, heading, score = search_anywhere(*args, 0.0, np.zeros(3), -1.0, -1.0)
    best = 0.0
    for r in range(turns):
        cells = np.floor(se2.transform(np.array([0.0, 0.0, 2 * np.pi * r / turns]), points) / 0.1).astype(int)
        for i in range(30):
            for j in range(26):
                at = cells + np.array([i, j])
                if np.hypot(*(0.1 * np.array([i, j]) - middle[:2])) > reach:
                    continue
                inside = ((at >= 0) & (at < field.shape)).all(1)
                best = max(best, float(field[tuple(at[inside].T)].sum()) / len(points))
    assert score == pytest.approx(best, abs=1e-6)
    *_, second = search_anywhere(*args, score - 0.5, np.array([x, y, heading]), 0.25, 0.3)
    assert second <= score


def test_a_piece_goes_where_a_closure_puts_it_and_its_old_tie_is_gone() -> None:
    path, tracker = (
        loop_path(40),
        Tracker(TrackingConfig(distance=0.25), MatchingConfig(), SegmentationConfig(), MotionConfig()),
    )
    rng = np.random.default_rng(5)
    for k, pose in enumerate(path):
        tracker.track(room_scan(pose, rng, index=k, walls=AROUND), pose)
    before, since = np.array(tracker.chain.poses), 6
    closure = next(factor for factor in tracker.chain.factors if factor.i == since)
    moved = type(closure)(0, since + 2, np.array([1.0, 2.0, 0.5]), closure.sqrt_information, "loop")
    tracker.chain.untie(since, moved, TrackingConfig().untied)
    after = np.array(tracker.chain.poses)
    np.testing.assert_array_equal(after[:since], before[:since])
    np.testing.assert_allclose(after[since + 2], se2.compose(before[0], moved.measured), atol=1e-12)
    np.testing.assert_allclose(
        se2.between(after[since:-1], after[since + 1 :]), se2.between(before[since:-1], before[since + 1 :]), atol=1e-9
    )
    ties = [factor for factor in tracker.chain.factors if factor.j == since]
    assert len(ties) == 1
    assert np.abs(ties[0].sqrt_information).max() < 0.01
