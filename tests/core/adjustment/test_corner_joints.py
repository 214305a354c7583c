"""Walls are joined where scans saw them meet, within what noise and the spacing of beams allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.adjustment.adjust import adjust_splines
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.adjustment.corner_joints import WallsInTurn, walls_in_turn, with_corners
from bspline_slam.adjustment.trimming import TrimmingConfig
from bspline_slam.corners import corners_of
from bspline_slam.lab.corner_gaps import CornerGaps
from bspline_slam.models import NormalDistance
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.spline_map import SplineMap
from core.mapped_room import MODEL, PATH, disturbed, seen_from
from core.rooms import ROOM
from core.test_corners import niche, wall

CONFIG = TrimmingConfig()
SEEN = WallsInTurn(3, 7, end=1.95, start=0.05, spacing=0.03)


def joined(splines: SplineMap, *seen: WallsInTurn, config: TrimmingConfig = CONFIG) -> list[tuple[int, int]]:
    after, joints = with_corners(splines, seen or (SEEN,), config, NormalDistance())
    assert [one.id for one in after] == [one.id for one in splines]
    assert sorted(corner.joint for corner in corners_of(after)) == sorted(joints)
    for one, other in zip(splines, after, strict=True):
        assert other is one or any(one.id in joint for joint in joints)
    return list(joints)


def test_the_walls_of_a_room_meet_in_its_corners() -> None:
    start = disturbed(0.03)
    keys, splines, factors = seen_from(start)
    after, _ = adjust_splines(
        keys, start, splines, factors, AdjustmentConfig(), MODEL, "direct", lambda fraction, record: None
    )
    corners = corners_of(after)
    true = np.unique(ROOM.reshape(-1, 2), axis=0)
    off = np.linalg.norm(np.array([corner.point for corner in corners])[:, None] - true, axis=-1)
    assert len(set(off.argmin(1).tolist())) == len(corners) >= 4
    assert off.min(1).max() < 0.03
    np.testing.assert_allclose(np.abs([corner.turn for corner in corners]), np.pi / 2, atol=0.1)
    assert CornerGaps.of(after).joined == len(corners)


def test_ends_short_of_the_crossing_and_beyond_it_are_brought_there() -> None:
    for short, over in [(0.04, 0.05), (-0.06, 0.0), (0.09, -0.0), (-0.09, 0.09)]:
        assert joined(niche(short=short, over=over)) == [(3, 7)]


@pytest.mark.parametrize(("short", "over"), [(0.15, 0.0), (0.0, -0.15), (0.06, -0.06), (-0.15, 0.0), (0.0, 0.15)])
def test_free_ends_stay_where_they_are(short: float, over: float) -> None:
    assert joined(niche(short=short, over=over)) == []


def test_sparse_beams_leave_wider_gaps() -> None:
    gap = niche(short=0.1, over=-0.05)
    assert joined(gap) == []
    assert joined(gap, replace(SEEN, spacing=0.12)) == [(3, 7)]


@pytest.mark.parametrize("seen", [replace(SEEN, end=2.05), replace(SEEN, start=-0.05)])
def test_a_wall_that_most_scans_saw_go_on_has_no_corner(seen: WallsInTurn) -> None:
    assert joined(niche(short=-0.08, over=0.08), seen) == []


def test_an_end_has_one_corner_the_nearest() -> None:
    splines = SplineMap((*niche(short=0.01, over=0.0), wall(8, pose=(0.05, 0.0, np.pi / 2), span=(0.0, 2.0))))
    assert joined(splines, replace(SEEN, after=8), SEEN) == [(3, 7)]


def test_splines_that_are_gone_or_too_short_are_left_out() -> None:
    assert joined(niche(), replace(SEEN, after=9), replace(SEEN, before=7)) == []
    assert joined(niche(), config=replace(CONFIG, shortest=3.0)) == []


def test_only_what_enough_key_scans_saw_in_turn_counts() -> None:
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, PATH, 0.1)
    found = walls_in_turn(splines, sights, feet, CONFIG)
    pairs = {(one.before, one.after) for one in found}
    assert len(pairs) == len(found) >= 4
    seldom = walls_in_turn(splines, sights, feet, replace(CONFIG, support=len(PATH)))
    assert {(one.before, one.after) for one in seldom} < pairs
    assert walls_in_turn(splines, sights, replace(feet, counts=np.zeros_like(feet.counts)), CONFIG) == ()
