"""Segmentation: what is cut, where, and that it does not depend on where the world's origin is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam import se2
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import EndKind, SegmentationConfig, segment_scan
from core.rooms import room_scan

ANYWHERE = st.tuples(st.floats(0.8, 3.0), st.floats(0.8, 2.0), st.floats(-3.0, 3.0)).map(np.array)


@given(ANYWHERE, st.integers(0, 5))
def test_segments_are_disjoint_runs_of_valid_beams(pose: np.ndarray, seed: int) -> None:
    scan = room_scan(pose, np.random.default_rng(seed))
    segments = segment_scan(scan)
    beams = np.concatenate([segment.beams for segment in segments])
    assert len(segments) >= 3
    assert (np.diff(beams) > 0).all()
    assert scan.valid[beams].all()
    assert [segment.index for segment in segments] == list(range(len(segments)))
    for segment in segments:
        np.testing.assert_allclose(segment.points, scan.points_robot[segment.beams])


@given(ANYWHERE, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_moving_the_sensor_on_the_robot_moves_segments_and_nothing_else(
    pose: np.ndarray, x: float, y: float, turn: float
) -> None:
    scan = room_scan(pose, np.random.default_rng(0))
    moved = replace(scan, pose_robot_sensor=np.array([x, y, turn]))
    back = se2.compose(scan.pose_robot_sensor, se2.inverse(moved.pose_robot_sensor))
    for one, other in zip(segment_scan(scan), segment_scan(moved), strict=True):
        assert (one.start, one.end) == (other.start, other.end)
        np.testing.assert_array_equal(one.beams, other.beams)
        np.testing.assert_allclose(one.points, se2.transform(back, other.points), atol=1e-9)


def test_corners_of_a_room_cut_and_are_called_corners() -> None:
    scan = room_scan(np.array([1.2, 1.5, 2.5]), np.random.default_rng(1), noise=0.0)
    segments = segment_scan(scan)
    ends = [segment.points[-1] for segment in segments if segment.end is EndKind.CORNER]
    world = se2.transform(np.array([1.2, 1.5, 2.5]), np.array(ends))
    corners = np.array([[0.0, 0.0], [0.0, 5.0], [2.5, 5.0]])
    for corner in corners:
        assert np.linalg.norm(world - corner, axis=1).min() < 0.15


def test_a_box_before_a_wall_has_edges_and_the_wall_behind_it_is_occluded() -> None:
    bearings = np.deg2rad(np.arange(-20.0, 21.0))
    wall = 4.0 / np.cos(bearings)
    ranges = np.where(np.abs(bearings) < np.deg2rad(8), 2.0 / np.cos(bearings), wall)
    scan = LaserScan(0, 0.0, ranges, bearings, 0.05, 20.0, np.zeros(3))
    left, box, right = segment_scan(scan)
    assert (left.start, left.end) == (EndKind.FIELD_OF_VIEW, EndKind.OCCLUDED)
    assert (box.start, box.end) == (EndKind.EDGE, EndKind.EDGE)
    assert (right.start, right.end) == (EndKind.OCCLUDED, EndKind.FIELD_OF_VIEW)


def test_beams_without_return_end_a_segment() -> None:
    bearings = np.deg2rad(np.arange(-20.0, 21.0))
    ranges = 3.0 / np.cos(bearings)
    ranges[18:23] = np.inf
    scan = LaserScan(0, 0.0, ranges, bearings, 0.05, 20.0, np.zeros(3))
    before, after = segment_scan(scan)
    assert before.end is EndKind.NO_RETURN
    assert after.start is EndKind.NO_RETURN


def test_one_lost_beam_is_bridged() -> None:
    bearings = np.deg2rad(np.arange(-20.0, 21.0))
    ranges = 3.0 / np.cos(bearings)
    ranges[20] = np.nan
    assert len(segment_scan(LaserScan(0, 0.0, ranges, bearings, 0.05, 20.0, np.zeros(3)))) == 1


def test_a_scan_of_nothing_has_no_segments() -> None:
    bearings = np.deg2rad(np.arange(-20.0, 21.0))
    scan = LaserScan(0, 0.0, np.full(41, np.inf), bearings, 0.05, 20.0, np.zeros(3))
    assert segment_scan(scan) == ()


def test_short_pieces_are_left_out() -> None:
    scan = room_scan(np.array([1.2, 1.5, 2.5]), np.random.default_rng(1))
    least = 12
    assert min(len(s.beams) for s in segment_scan(scan, SegmentationConfig(least_points=least))) >= least


@given(st.floats(-0.4, 0.4), st.floats(0.05, 0.95), st.booleans())
def test_a_beam_that_lit_both_sides_of_a_jump_belongs_to_neither(slant: float, share: float, mirrored: bool) -> None:
    bearings = np.deg2rad(np.arange(-20.0, 21.0))
    near, far = 2.0 / np.cos(bearings + slant), 3.0 / np.cos(bearings)
    ranges = np.where(bearings < -1e-9, near, far)
    sound = _beams_by_piece(ranges, bearings)
    ranges[20] = near[20] + 0.03 + 0.9 * share
    mixed = _beams_by_piece(ranges[::-1] if mirrored else ranges, bearings)
    assert [len(beams) for beams in sound] == [20, 21]
    assert all(20 not in beams for beams in mixed)
    assert sum(map(len, mixed)) >= 38


def test_ends_that_stay_on_their_wall_stay_in_the_segment() -> None:
    scan = room_scan(np.array([1.2, 1.5, 2.5]), np.random.default_rng(3), noise=0.004)
    kept = segment_scan(scan)
    all_of_them = segment_scan(scan, replace(SegmentationConfig(), mixed=np.inf))
    for one, other in zip(kept, all_of_them, strict=True):
        np.testing.assert_array_equal(one.beams, other.beams)


def _beams_by_piece(ranges: np.ndarray, bearings: np.ndarray) -> list[np.ndarray]:
    scan = LaserScan(0, 0.0, ranges, bearings, 0.05, 20.0, np.zeros(3))
    return [segment.beams for segment in segment_scan(scan)]
