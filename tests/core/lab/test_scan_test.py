"""Normalised squares against their bands."""

from __future__ import annotations

import numpy as np

from bspline_slam.lab.scan_test import ScanTest


def test_honest_squares_lie_inside_as_often_as_the_band_says() -> None:
    rng = np.random.default_rng(0)
    dof = rng.integers(1, 60, 4000).astype(float)
    test = ScanTest(np.arange(4000), rng.chisquare(dof), dof)
    assert 0.94 < test.inside.mean() < 0.96
    assert abs(test.normalised.mean() - 1.0) < 0.03


def test_the_worst_scan_is_the_one_farthest_above_its_own_band() -> None:
    dof = np.array([3.0, 90.0, 3.0])
    test = ScanTest(np.array([4, 8, 15]), np.array([9.0, 180.0, 0.001]), dof)
    assert test.worst == 8
    assert test.inside.tolist() == [True, False, False]


def test_of_no_scan_none_is_the_worst() -> None:
    nothing = np.zeros(0)
    assert ScanTest(np.zeros(0, dtype=np.int64), nothing, nothing).worst is None
