"""Loop closures: a place seen again is found, a place like it is not believed, and every verdict has its reason."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end import loop_closer
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closer import LoopCloser, candidates, propose, window
from bspline_slam.front_end.loop_closure import LoopClosure, LoopConfig, Proposal
from bspline_slam.front_end.scan_matching import MatchingConfig, point_set
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.graph import PoseFactor
from bspline_slam.logs import open_log
from bspline_slam.segmentation import SegmentationConfig
from bspline_slam.slam import Slam
from bspline_slam.snapshot import Snapshot
from core.rooms import ROOM, room_scan

CONFIG = LoopConfig(half_width=2, least_travel=4.0)
START = np.array([[1.5 + 0.2 * k, 1.2, 0.1 * k] for k in range(5)])


def key(pose: np.ndarray, travel: float, seed: int, walls: np.ndarray = ROOM) -> KeyScan:
    scan = room_scan(pose, np.random.default_rng(seed), walls=walls)
    return KeyScan(seed, point_set(scan, MatchingConfig(), SegmentationConfig()), travel)


def again(pose: np.ndarray, travel: float = 20.0, walls: np.ndarray = ROOM) -> list[KeyScan]:
    """Five key scans at the start, then one much later at `pose`."""
    return [*(key(p, 0.2 * k, k) for k, p in enumerate(START)), key(pose, travel, 99, walls)]


def test_a_place_seen_again_is_measured_in_spite_of_drift() -> None:
    truth = np.array([1.9, 1.4, 0.4])
    drifted = se2.compose(truth, np.array([0.3, -0.2, 0.1]))
    keys = again(truth)
    proposal = propose(keys, np.vstack([START, drifted]), 2, 15.0, CONFIG, MatchingConfig(), TrackingConfig())
    off = se2.between(se2.between(START[2], truth), proposal.closure.measured)
    assert proposal.closure.accepted
    assert np.hypot(off[0], off[1]) < 0.02
    assert abs(off[2]) < 0.01
    assert np.linalg.eigvalsh(proposal.closure.covariance).min() > 0


def test_another_room_is_rejected_with_a_reason() -> None:
    other = np.array([[[-1.0, -9.0], [-1.0, 9.0]], [[8.0, -9.0], [3.0, 9.0]], [[-1.0, 7.0], [8.0, 9.0]]])
    pose = np.array([1.9, 1.4, 0.4])
    keys = again(pose, walls=other)
    proposal = propose(keys, np.vstack([START, pose]), 2, 0.0, CONFIG, MatchingConfig(), TrackingConfig())
    assert not proposal.closure.accepted
    assert "below" in proposal.closure.reason or "beams" in proposal.closure.reason


def test_candidates_were_left_behind_long_enough_ago_and_lie_near() -> None:
    keys = again(np.array([1.9, 1.4, 0.4]))
    poses = np.vstack([START, [1.9, 1.4, 0.4]])
    assert candidates(keys, poses, 0.4, CONFIG)
    assert candidates(again(poses[-1], travel=3.0), poses, 0.4, CONFIG) == []
    far = np.vstack([START, [30.0, 1.4, 0.4]])
    assert candidates(keys, far, 0.4, CONFIG) == []


def test_the_window_grows_with_travel_to_a_limit() -> None:
    near, far, furthest = (window(travel, CONFIG) for travel in (0.0, 50.0, 1e6))
    assert near == (CONFIG.least_reach, CONFIG.least_turn)
    assert near[0] < far[0] < furthest[0] == CONFIG.most_reach
    assert near[1] < far[1] <= furthest[1] == CONFIG.most_turn


def test_a_closure_that_would_move_the_map_waits_for_a_second_one_that_agrees() -> None:
    closer = LoopCloser(LoopConfig(half_width=2, least_travel=4.0, tries=1), MatchingConfig(), TrackingConfig())
    truth = np.array([[1.9, 1.4, 0.4], [2.1, 1.4, 0.45]])
    drift = np.array([0.5, -0.4, 0.15])
    keys, poses = again(truth[0], travel=40.0), np.vstack([START, se2.compose(truth[0], drift)])
    closer.look(keys, poses)
    assert closer.found(keys, poses) == []
    assert len(closer.waiting) == 1
    keys = [*keys, key(truth[1], 40.3, 100)]
    poses = np.vstack([poses, se2.compose(poses[-1], se2.between(truth[0], truth[1]))])
    closer.look(keys, poses)
    fresh = closer.found(keys, poses)
    assert len(fresh) == 2
    assert closer.waiting == []
    assert sum(closure.accepted for closure in closer.closures) == 2


def test_a_closure_along_a_bare_wall_leaves_the_search_as_wide_as_it_was() -> None:
    wall = np.array([[[-50.0, 0.0], [50.0, 0.0]]])
    for walls, settled in ((wall, False), (ROOM, True)):
        closer = LoopCloser(LoopConfig(half_width=2, least_travel=4.0, tries=1), MatchingConfig(), TrackingConfig())
        keys = [key(p, 0.2 * k, k, walls) for k, p in enumerate(START)]
        keys, poses = [*keys, key(START[2], 20.0, 99, walls)], np.vstack([START, START[2]])
        closer.look(keys, poses)
        assert len(closer.found(keys, poses)) == 1
        assert (closer.closed_at == 20.0) == settled


def test_a_closure_that_nobody_confirms_is_rejected_and_says_so() -> None:
    closer = LoopCloser(LoopConfig(half_width=2, least_travel=4.0, tries=1), MatchingConfig(), TrackingConfig())
    truth = np.array([1.9, 1.4, 0.4])
    keys, poses = again(truth, travel=40.0), np.vstack([START, se2.compose(truth, np.array([0.5, -0.4, 0.15]))])
    closer.look(keys, poses)
    assert closer.found(keys, poses) == []
    (waiting,) = closer.told
    assert (waiting.verdict, waiting.accepted, closer.closures) == ("waiting", False, [])
    assert "waits for a second closure" in waiting.reason
    away = np.array([[0.0, -60.0], [0.0, -60.0]])[None] + 0.0
    keys = [*keys, key(np.array([0.0, -50.0, 0.0]), 60.0, 101, away)]
    assert closer.found(keys, np.vstack([poses, [0.0, -50.0, 0.0]])) == []
    assert closer.waiting == []
    assert "no second closure" in closer.closures[-1].reason
    assert closer.told == tuple(closer.closures)


def accepted_closure(i: int, j: int, poses: np.ndarray, off: np.ndarray) -> Proposal:
    """A closure between key scans 10 i and 10 j that is wrong by `off` (seen from the later one), 1 cm and 3 mrad."""
    measured, sigmas = se2.compose(se2.between(poses[i], poses[j]), off), np.array([0.01, 0.01, 0.003])
    closure = LoopClosure(10 * i, 10 * j, measured, np.diag(sigmas**2), 0.8, 0.9, accepted=True, reason="fits")
    return Proposal(closure, PoseFactor(i, j, measured, np.diag(1.0 / sigmas), "loop", 1.0))


def closer_with(*proposals: Proposal) -> LoopCloser:
    closures = [proposal.closure for proposal in proposals]
    return LoopCloser(CONFIG, MatchingConfig(), TrackingConfig(), closures, list(proposals))


@pytest.mark.parametrize("off", [(1.0, 0.2, 0.0), (0.0, 0.0, 0.1)])
def test_a_closure_that_the_finished_map_contradicts_is_taken_back_and_says_why(off: tuple[float, ...]) -> None:
    right, wrong = accepted_closure(0, 3, START, np.zeros(3)), accepted_closure(1, 4, START, np.array(off))
    closer = closer_with(right, wrong)
    assert closer.reject_contradicted(START)
    assert closer.accepted == [right]
    assert [closure.accepted for closure in closer.closures] == [True, False]
    assert "standard deviations" in closer.closures[1].reason
    assert not closer.reject_contradicted(START)


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.055, 0.0, 0.0), (0.09, 0.0, 0.02)])
def test_a_closure_that_is_merely_inexact_stays(off: tuple[float, ...]) -> None:
    closer = closer_with(accepted_closure(0, 3, START, np.array(off)))
    assert not closer.reject_contradicted(START)
    assert closer.closures[0].accepted


def test_a_closure_that_knows_little_is_not_contradicted_by_much() -> None:
    known = accepted_closure(0, 3, START, np.array([0.5, 0.0, 0.0]))
    vague = Proposal(known.closure, PoseFactor(0, 3, known.closure.measured, np.diag([5.0, 5.0, 5.0]), "loop", 1.0))
    assert not closer_with(vague).reject_contradicted(START)


class AtOnce:
    """A thread so fast that it is done before the next line."""

    def __init__(self, *_: object) -> None: ...

    def submit(self, work: Callable[..., Any], *arguments: object) -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result(work(*arguments))
        return done


class AtTheLastMoment(Future[Any]):
    """A thread so slow that it begins only when its result is waited for."""

    def __init__(self, *_: object) -> None:
        super().__init__()

    def submit(self, work: Callable[..., Any], *arguments: object) -> AtTheLastMoment:
        later = AtTheLastMoment()
        later.result = lambda timeout=None: work(*arguments)
        return later


def office_read_by(executor: type, patch: pytest.MonkeyPatch) -> Snapshot:
    with patch.context() as context:
        context.setattr(loop_closer, "ThreadPoolExecutor", executor)
        slam = Slam(open_log(Path(__file__).parents[3] / "sample_logs" / "office.log.gz"))
        for _ in islice(slam.steps(), 260):
            pass
        return slam.snapshot()


def test_nothing_hangs_on_how_fast_the_thread_is(monkeypatch: pytest.MonkeyPatch) -> None:
    fast, slow = (office_read_by(executor, monkeypatch) for executor in (AtOnce, AtTheLastMoment))
    assert sum(closure.accepted for closure in fast.loop_closures) > 5
    np.testing.assert_array_equal(fast.poses, slow.poses)
    assert [spline.id for spline in fast.map] == [spline.id for spline in slow.map]
    for one, other in zip(fast.map, slow.map, strict=True):
        np.testing.assert_array_equal(one.curve.control_points, other.curve.control_points)
