"""Maps as values: splines by id, and the stretch of each that scans support."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.spline_map import MapSpline, SplineMap


def wall(spline_id: int, span: tuple[float, float] = (0.0, 7.0)) -> MapSpline:
    """A straight wall on which a parameter step of one is one metre."""
    curve = BSpline(3, uniform_knots(0.0, 1.0, 10), np.stack([np.arange(10.0), np.zeros(10)], -1))
    return MapSpline(spline_id, curve, span, born=0)


def test_splines_are_found_by_id() -> None:
    spline_map = SplineMap((wall(2), wall(5)))
    assert spline_map[5] is spline_map.splines[1]
    assert 2 in spline_map
    assert 3 not in spline_map
    assert [spline.id for spline in spline_map] == [2, 5]
    assert (len(spline_map), spline_map.control_point_count) == (2, 20)


def test_a_spline_that_is_not_there_is_named() -> None:
    with pytest.raises(KeyError, match="no spline 7"):
        SplineMap((wall(2),))[7]


def test_samples_and_length_keep_to_the_supported_stretch() -> None:
    spline = wall(0, span=(2.0, 4.5))
    t, points = spline.sample(0.1)
    assert (t[0], t[-1]) == (2.0, 4.5)
    np.testing.assert_allclose(spline.length, 2.5)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.1)
