"""The growing map: one wall is one spline, seen again it is matched, and ids last."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bspline_slam import se2
from bspline_slam.association import Association, AssociationConfig, Verdict
from bspline_slam.front_end.mapping import MapBuilder, carried
from bspline_slam.models import NormalDistance
from bspline_slam.segmentation import segment_scan
from core.rooms import loop_path, room_scan


def built(
    poses: np.ndarray, seed: int = 0, move: np.ndarray = se2.IDENTITY
) -> tuple[MapBuilder, list[tuple[Association, ...]]]:
    """The map from scans at `poses`, all of it moved by `move`."""
    rng = np.random.default_rng(seed)
    builder = MapBuilder(AssociationConfig(), NormalDistance())
    scans = [room_scan(pose, rng, index=k) for k, pose in enumerate(poses)]
    return builder, [builder.add(k, se2.compose(move, poses[k]), segment_scan(scan)) for k, scan in enumerate(scans)]


def beams(decided: Sequence[Association], *verdicts: Verdict) -> int:
    return sum(a.last - a.first + 1 for a in decided if a.verdict in verdicts)


def test_a_first_scan_starts_splines_and_a_second_from_the_same_place_starts_none() -> None:
    pose = np.array([2.0, 1.5, 0.3])
    builder, (first, second) = built(np.array([pose, pose]))
    assert {a.verdict for a in first} <= {Verdict.NEW, Verdict.GATED}
    assert beams(second, Verdict.MATCHED) > 0.95 * beams(second, *Verdict)
    assert all(a.by == "rule" for a in second)
    assert len(builder.map) >= 4


def test_a_loop_around_the_room_finds_each_wall_once() -> None:
    builder, decided = built(loop_path(30))
    last = decided[-1]
    assert beams(last, Verdict.MATCHED) > 0.9 * beams(last, *Verdict)
    solid = [s for s in builder.map if s.observations >= 3]
    outline = 2 * (6.0 + 5.0) + 4 * 0.6
    assert 0.6 * outline < sum(s.length for s in solid) < 1.25 * outline


def test_curves_lie_on_the_walls() -> None:
    builder, _ = built(loop_path(30))
    for spline in builder.map:
        _, points = spline.sample(0.1)
        x, y = points[:, 0], points[:, 1]
        to_lines = [np.abs(x), np.abs(x - 6), np.abs(x - 2.5), np.abs(y), np.abs(y - 5), np.abs(y - 4)]
        to_box = [np.abs(x - 4), np.abs(x - 4.6), np.abs(y - 2.5), np.abs(y - 3.1)]
        assert np.min([*to_lines, *to_box], axis=0).max() < 0.08


def test_the_map_turns_with_the_world() -> None:
    move = np.array([3.0, -2.0, 1.1])
    here, _ = built(loop_path(8))
    there, _ = built(loop_path(8), move=move)
    assert [s.id for s in here.map] == [s.id for s in there.map]
    for one, other in zip(here.map, there.map, strict=True):
        np.testing.assert_allclose(se2.transform(move, one.curve.control_points), other.curve.control_points, atol=1e-5)


def test_every_id_in_a_decision_is_in_the_map_under_its_heir() -> None:
    builder, decided = built(loop_path(30), seed=3)
    ids = {spline.id for spline in builder.map}
    named = {a.spline for scan in decided for a in scan if a.spline is not None}
    assert {builder.heir(k) for k in named} <= ids
    assert all(spline.history for spline in builder.map)


def test_a_rebuilt_map_keeps_its_ids() -> None:
    poses = loop_path(12)
    first, decided = built(poses)
    began = {(a.scan, a.segment): first.heir(a.spline) for s in reversed(decided) for a in s if a.spline is not None}
    rng = np.random.default_rng(0)
    again = MapBuilder(
        AssociationConfig(), NormalDistance(), lambda s, k: began.get((s, k), -1), first_id=first.next_id
    )
    for k, pose in enumerate(poses):
        again.add(k, pose, segment_scan(room_scan(pose, rng, index=k)))
    assert {s.id for s in again.map if s.observations > 3} <= {s.id for s in first.map}


def test_a_map_carried_along_turns_with_its_key_scans() -> None:
    poses, move = loop_path(8), np.array([3.0, -2.0, 1.1])
    builder, _ = built(poses)
    before = builder.map
    builder.carry(np.arange(8), poses, se2.compose(move, poses))
    for old, new in zip(before, builder.map, strict=True):
        assert (old.id, old.span) == (new.id, new.span)
        np.testing.assert_allclose(se2.transform(move, old.curve.control_points), new.curve.control_points, atol=1e-9)


def test_points_near_a_key_scan_go_with_it() -> None:
    places = np.array([[0.0, 0.0], [10.0, 0.0]])
    moves = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    moved = carried(np.array([[0.0, 0.1], [5.0, 0.0], [10.0, 0.1]]), places, moves)
    np.testing.assert_allclose(moved, [[0.0, 0.1], [5.0, 0.5], [10.0, 1.1]], atol=2e-3)


def test_what_later_scans_drew_is_forgotten() -> None:
    poses = loop_path(20)
    builder, _ = built(poses)
    early, _ = built(poses[:12])
    builder.forget(12)
    assert {s.id for s in builder.map} <= {s.id for s in early.map}
    assert all(s.born < 12 and s.observations <= 12 for s in builder.map)
