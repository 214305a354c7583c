"""Iterations of a solve: few are kept, and the map goes along with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app import views
from bspline_slam import se2
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.slam import Snapshot
from splinescope.computing.iterations import MOST_FRAMES, at_frame, frames_of


def solved(rng: np.random.Generator) -> Snapshot:
    world = views.floor_map(rng=rng)
    return Snapshot(views.path_through(2, 1, 30, rng), np.arange(0, 30, 3), (), world, ())


def records(snapshot: Snapshot, count: int) -> list[IterationRecord]:
    poses, points = snapshot.poses[snapshot.key_scans], np.zeros((snapshot.map.control_point_count, 2))
    return [IterationRecord(i, 100.0 - i, 0.1, 0.1, 0.0, poses, points) for i in range(count)]


@pytest.mark.parametrize("count", [0, 1, 2, MOST_FRAMES, 400])
def test_few_frames_are_kept_of_any_solve_with_both_its_ends(count: int) -> None:
    frames = frames_of(records(solved(np.random.default_rng(1)), count))
    numbers = [frame.iteration for frame in frames]
    assert len(numbers) == min(count, MOST_FRAMES)
    assert numbers == sorted(set(numbers))
    assert not count or (numbers[0], numbers[-1]) == (0, count - 1)


def test_a_frame_of_another_round_moves_each_curve_with_its_first_key_scan() -> None:
    snapshot = solved(np.random.default_rng(2))
    shift = np.array([0.5, -0.2, 0.3])
    poses = se2.compose(shift, snapshot.poses[snapshot.key_scans])
    frame = replace(frames_of(records(snapshot, 1))[0], poses=poses, control_points=np.zeros((3, 2)))
    before = at_frame(snapshot, frame)
    assert before.poses == pytest.approx(se2.compose(shift, snapshot.poses), abs=1e-9)
    for moved, still in zip(before.map, snapshot.map, strict=True):
        expected = se2.transform(shift, still.curve.control_points)
        assert moved.curve.control_points == pytest.approx(expected, abs=1e-9)


def test_a_frame_of_other_key_scans_changes_nothing() -> None:
    snapshot = solved(np.random.default_rng(3))
    frame = replace(frames_of(records(snapshot, 1))[0], poses=np.zeros((2, 3)))
    assert at_frame(snapshot, frame) is snapshot
