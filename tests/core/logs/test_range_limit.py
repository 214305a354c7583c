"""The no-return limit is found for the sensors that public logs were recorded with, and never inside a room."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.logs.range_limit import range_limit


def building(rng: np.random.Generator, far: float, limit: float | None, share: float = 0.1) -> list[np.ndarray]:
    """Scans with walls nearer than `far` at centimetre resolution, a share of the beams without return."""
    scans = np.round(rng.gamma(2.0, far / 12.0, (200, 180)).clip(0.1, far), 2)
    scans[scans >= far] = np.round(rng.uniform(0.5, far, np.count_nonzero(scans >= far)), 2)
    if limit is not None:
        scans[rng.random(scans.shape) < share] = limit
    return list(scans)


@pytest.mark.parametrize(
    ("far", "limit"), [(7.5, 8.0), (7.9, 8.191), (15, 16.383), (25, 30.0), (31, 32.767), (40, 50.0)]
)
@pytest.mark.parametrize("share", [0.002, 0.1, 0.6])
def test_limits_of_known_sensors(far: float, limit: float, share: float) -> None:
    found = range_limit(building(np.random.default_rng(1), far, limit, share), None)
    assert far <= found <= limit


def test_codes_of_sick_scanners_all_count() -> None:
    scans = building(np.random.default_rng(2), 40, 81.91)
    scans[7][3] = 81.83
    assert range_limit(scans, None) == 81.83


def test_odd_limit_is_seen_by_its_frequency() -> None:
    assert range_limit(building(np.random.default_rng(3), 5.4, 5.6), None) == 5.6


def test_limit_below_the_error_code() -> None:
    scans = building(np.random.default_rng(4), 28, 29.9, 0.2)
    for scan in scans[::10]:
        scan[::60] = 81.91
    assert range_limit(scans, None) == 29.9


def test_outliers_beyond_the_limit_do_not_hide_it() -> None:
    scans = building(np.random.default_rng(5), 40, 50.0)
    scans[0][0], scans[9][1] = 163.2, 75.1
    assert range_limit(scans, None) == 50.0


def test_nothing_inside_a_room_is_a_limit() -> None:
    scans = building(np.random.default_rng(6), 6.0, None)
    assert range_limit(scans, None) == 8.183
    standing = [np.round(np.linspace(2.0, 7.32, 180), 2)] * 300
    assert range_limit(standing, None) == 8.183
    assert range_limit([np.full(180, 5.0)] * 20, None) == 8.183


def test_announced_limit_holds_unless_contradicted() -> None:
    scans = building(np.random.default_rng(7), 20.0, None)
    assert range_limit(scans, 30.0) == 30.0
    assert range_limit(scans, 5.0) > 19.0
    assert range_limit(building(np.random.default_rng(7), 20.0, 81.83, 0.3), 30.0) == 30.0
    assert range_limit(building(np.random.default_rng(7), 20.0, 50.0), 80.0) == 50.0


def test_without_any_reading() -> None:
    assert range_limit([], None) > 8 and range_limit([np.full(10, np.nan)], 20.0) == 20.0


def test_readings_beyond_all_sensors_stay_valid() -> None:
    assert range_limit([np.linspace(1, 200.0, 100)], None) > 200.0
