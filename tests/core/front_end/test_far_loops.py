"""Far loops: a place is found again from many metres off, inside the uncertainty of the way and only if it is the only
one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.far_loops import FarCloser, FarLoopConfig, chain_covariance
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closer import LoopCloser
from bspline_slam.front_end.loop_closure import LoopClosure, LoopConfig, Proposal
from bspline_slam.front_end.scan_matching import MatchingConfig, point_set
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.graph import PoseFactor
from bspline_slam.segmentation import SegmentationConfig
from core.rooms import ROOM, loop_path, room_scan

SQUARE = np.array(
    [[[0.0, 0.0], [5.0, 0.0]], [[5.0, 0.0], [5.0, 5.0]], [[5.0, 5.0], [0.0, 5.0]], [[0.0, 5.0], [0.0, 0.0]]]
)
AWAY = np.array([11.0, -8.0, 0.4])
TIGHT, LOOSE = np.array([0.01, 0.01, 0.003]), np.array([6.0, 6.0, 0.5])


def step(i: int, poses: np.ndarray, sigmas: np.ndarray) -> PoseFactor:
    return PoseFactor(i, i + 1, se2.between(poses[i], poses[i + 1]), np.diag(1.0 / sigmas), "matching")


def closure(i: int, j: int, poses: np.ndarray) -> Proposal:
    measured = se2.between(poses[i], poses[j])
    told = LoopClosure(i, j, measured, np.diag(TIGHT**2), 0.9, 0.9, accepted=True, reason="fits")
    return Proposal(told, PoseFactor(i, j, measured, np.diag(1.0 / TIGHT), "loop", 1.0))


def looked_for(known: np.ndarray, again: np.ndarray, walls: np.ndarray, sigmas: np.ndarray) -> tuple[Proposal, ...]:
    """What is found by a robot that comes back `again` and believes to be far away, this uncertain of the way."""
    path, rng = np.concatenate([known, again]), np.random.default_rng(7)
    scans = [room_scan(pose, rng, index=k, walls=walls) for k, pose in enumerate(path)]
    sets = [point_set(scan, MatchingConfig(), SegmentationConfig()) for scan in scans]
    keys = [KeyScan(k, one, 0.5 * k + 40.0 * (k >= len(known))) for k, one in enumerate(sets)]
    poses = np.concatenate([known, se2.compose(AWAY, again)])
    factors = [step(k, poses, sigmas if k == len(known) - 1 else TIGHT) for k in range(len(poses) - 1)]
    config, matching, tracking, loops = FarLoopConfig(), MatchingConfig(), TrackingConfig(), LoopConfig()
    far, closer = FarCloser(config, matching, tracking, loops), LoopCloser(loops, matching, tracking)
    for n in range(len(known) + 1, len(keys) + 1):
        found = far.look(keys[:n], poses[:n], factors[: n - 1], closer)
        if found:
            return found
    return ()


def test_a_place_is_found_again_from_far_off() -> None:
    path = loop_path(40)
    known, again = path[:36], path[4:30] + np.array([0.1, 0.05, 0.02])
    found = looked_for(known, again, ROOM, LOOSE)
    assert len(found) == FarLoopConfig().finds
    for proposal in found:
        off = se2.between(again[proposal.j - len(known)], se2.compose(known[proposal.i], proposal.closure.measured))
        assert np.hypot(off[0], off[1]) < 0.05
        assert abs(off[2]) < 0.02
        assert "fits nowhere else" in proposal.closure.reason


def test_nothing_is_looked_for_beyond_what_is_uncertain() -> None:
    path = loop_path(40)
    assert looked_for(path[:36], path[4:30], ROOM, TIGHT) == ()
    assert looked_for(path[:36], path[4:30], ROOM, 0.1 * LOOSE) == ()


def test_a_place_that_looks_alike_from_several_sides_is_not_decided() -> None:
    path = np.array([[2.5 + np.cos(a), 2.5 + np.sin(a), a] for a in np.linspace(0.0, 6.0, 30)])
    assert looked_for(path, path[2:24], SQUARE, np.array([6.0, 6.0, 1.5])) == ()


@pytest.mark.parametrize("seed", range(3))
def test_errors_of_a_chain_add_up_as_in_its_pose_graph(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 7
    poses = np.cumsum(rng.normal(size=(n, 3)), axis=0)
    factors = [
        replace(step(i, poses, TIGHT), sqrt_information=rng.normal(size=(3, 3)) + 3.0 * np.eye(3)) for i in range(n - 1)
    ]
    covariance = chain_covariance(factors, [], poses)
    for i in range(n - 1):
        information = np.zeros((3 * n, 3 * n))
        for factor in factors[i:]:
            by = np.zeros((3, 3 * n))
            a, b = slice(3 * factor.i, 3 * factor.i + 3), slice(3 * factor.j, 3 * factor.j + 3)
            by[:, a], by[:, b] = factor.jacobians(poses[factor.i], poses[factor.j])
            information += by.T @ by
        free = information[3 * i + 3 :, 3 * i + 3 :]
        np.testing.assert_allclose(covariance[i], np.linalg.inv(free)[-3:, -3:], rtol=1e-4)
    assert np.abs(covariance[-1]).max() == 0.0


def test_what_a_closure_spans_hangs_together() -> None:
    poses = loop_path(9)
    factors = [step(i, poses, TIGHT) for i in range(8)]
    free, closed = chain_covariance(factors, [], poses), chain_covariance(factors, [closure(2, 6, poses)], poses)
    np.testing.assert_allclose(closed[6:], free[6:])
    np.testing.assert_allclose(closed[2:6], np.broadcast_to(free[6], (4, 3, 3)))
    assert (np.linalg.eigvalsh(free[:2] - closed[:2])[:, -1] > 0).all()
    assert (np.linalg.eigvalsh(closed[:2] - closed[2])[:, -1] > 0).all()
