"""The tests of consistency drawn and put in words."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.lab.scan_test import ScanTest
from splinescope.palette import DARK, LIGHT, Theme
from splinescope.pictures.consistency import in_words, next_outside, scan_test_picture


def scan_test(*normalised: float) -> ScanTest:
    """Poses of key scans 0, 5, 10, …"""
    count = len(normalised)
    return ScanTest(5 * np.arange(count), 3.0 * np.array(normalised), np.full(count, 3.0))


def test_every_key_scan_is_drawn_once() -> None:
    drawn = scan_test_picture(scan_test(0.5, 1.0, 2.0, 30.0, 0.001), 5, "NEES", DARK)
    assert drawn.count("<circle") == 4
    assert 'r="3.2"' in drawn
    assert "nan" not in drawn


@pytest.mark.parametrize("theme", [DARK, LIGHT])
@pytest.mark.parametrize("values", [(1.0,), (0.0, 1e9), (np.inf, 1.0)])
def test_extremes_stay_in_the_picture(values: tuple[float, ...], theme: Theme) -> None:
    drawn = scan_test_picture(scan_test(*values), 0, "NIS", theme)
    heights = [float(part.split('"')[1]) for part in drawn.split("cy=")[1:]]
    assert all(0.0 < height < 150.0 for height in heights)


def test_words_say_how_many_lie_where() -> None:
    assert in_words(scan_test(1.0, 30.0, 0.001, 40.0)) == "1 of 4 key scans (25%) lie inside, 2 above and 1 below it."
    assert in_words(scan_test(1.0, 1.2)) == "2 of 2 key scans (100%) lie inside."


def test_the_way_to_scans_above_the_band_is_a_circle() -> None:
    test = scan_test(1.0, 30.0, 0.001, 40.0, 1.0)
    assert [next_outside(test, cursor) for cursor in (0, 5, 7, 15, 20)] == [5, 15, 15, 5, 5]
    assert next_outside(scan_test(1.0, 1.0), 0) is None
