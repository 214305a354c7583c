"""How far walls end from their crossings, of joined corners and of open ones."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.corners import meeting
from bspline_slam.lab.corner_gaps import CornerGaps, nearest_gaps
from bspline_slam.spline_map import SplineMap
from core.test_corners import niche, wall


def test_the_farther_end_tells_the_gap() -> None:
    gaps = CornerGaps.of(niche(short=0.03, over=0.02))
    assert (gaps.corners, gaps.joined) == (1, 0)
    assert gaps.mean == gaps.percentile_95 == pytest.approx(0.03, abs=1e-9)


def test_joined_corners_have_none() -> None:
    gaps = CornerGaps.of(meeting(niche(), [(3, 7)]))
    assert (gaps.corners, gaps.joined) == (1, 1)
    assert gaps.mean < 1e-9


def test_each_end_counts_once() -> None:
    third = wall(8, pose=(0.05, 0.0, np.pi / 2), span=(0.0, 2.0))
    assert nearest_gaps(SplineMap((*niche(short=0.01, over=0.0), third))) == pytest.approx([0.01])


def test_walls_far_apart_are_no_corner() -> None:
    for splines in (SplineMap(), niche(short=0.2), niche(turn=0.1)):
        gaps = CornerGaps.of(splines)
        assert (gaps.corners, gaps.joined) == (0, 0)
        assert np.isnan(gaps.mean)
