"""The part of the world that is shown with a thing holds the thing, and a little around it."""

from __future__ import annotations

import numpy as np
import pytest

from app import views
from splinescope.edits.subject import subject_of
from splinescope.surroundings import AROUND, surroundings
from splinescope.view import Selection, View


@pytest.fixture(scope="module")
def view() -> View:
    return views.office(np.random.default_rng(5))


def test_the_rectangle_lies_closely_around_what_is_selected(view: View) -> None:
    assert view.map is not None and view.scan is not None
    spline, pose = view.map.map.splines[0], view.map.key_poses[3]
    for selection, points in (
        (Selection("spline", spline.id), spline.sample(0.2)[1]),
        (Selection("key pose", view.map.key_scans[3]), pose[None, :2]),
        (None, view.scan.pose[None, :2]),
    ):
        found = surroundings(view.scan, view.map, subject_of(selection, view.scan, view.map, 0), selection)
        assert found == pytest.approx((*(points.min(0) - AROUND), *(points.max(0) + AROUND)))


def test_nothing_is_around_where_nothing_is_shown(view: View) -> None:
    assert surroundings(None, view.map, subject_of(None, None, None, 0), None) is None
