"""A scan is held against walls where walls were known, and only there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.front_end.contradiction import compared
from core.rooms import ROOM, room_scan

HERE = np.array([1.5, 1.5, 0.3])
SCAN = room_scan(HERE, np.random.default_rng(0))
WALLS = se2.transform(HERE, SCAN.points_robot)


def test_a_scan_agrees_with_itself() -> None:
    known, agreeing = compared(SCAN, WALLS, HERE, 40.0)
    assert known == agreeing == 1.0


@pytest.mark.parametrize("seed", range(3))
def test_a_scan_of_another_place_does_not_agree(seed: int) -> None:
    scan = room_scan(HERE, np.random.default_rng(seed), walls=1.9 * ROOM[:, ::-1] - 0.6)
    known, agreeing = compared(scan, WALLS, HERE, 40.0)
    assert known > 0.8
    assert agreeing < 0.35 * known


def test_nothing_is_expected_where_the_laser_does_not_reach() -> None:
    near = replace(SCAN, ranges=np.minimum(SCAN.ranges, 0.9), range_max=1.0)
    assert compared(near, ROOM.reshape(-1, 2) + 50.0, HERE, 40.0) == (0.0, 0.0)


def test_beams_without_return_say_nothing() -> None:
    blank = replace(SCAN, ranges=np.full(361, np.inf))
    assert compared(blank, WALLS, HERE, 40.0) == (0.0, 0.0)
