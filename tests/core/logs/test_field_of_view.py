"""Bearings of lasers that only say how many beams they have."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.logs.field_of_view import bearings_of_count, count_is_known


@pytest.mark.parametrize(
    ("beams", "first", "last"),
    [
        (180, -90, 89),
        (181, -90, 90),
        (360, -90, 89.5),
        (361, -90, 90),
        (541, -135, 135),
        (1081, -135, 135),
        (401, -50, 50),
    ],
)
def test_known_sensors(beams: int, first: float, last: float) -> None:
    assert np.rad2deg(bearings_of_count(beams)[[0, -1]]) == pytest.approx([first, last])
    assert count_is_known(beams)


@given(st.integers(1, 3000))
def test_bearings_increase_evenly_and_face_ahead(beams: int) -> None:
    bearings = bearings_of_count(beams)
    steps = np.diff(bearings)
    assert len(bearings) == beams
    assert np.all(steps > 0) and np.allclose(steps, steps[:1].mean() if beams > 1 else 0)
    assert beams == 1 or abs(bearings.mean()) <= steps[0] / 2 + 1e-9
