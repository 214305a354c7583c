"""The ruler: what can be measured from, where it lies, and what the panel reads."""

from __future__ import annotations

import numpy as np
import pytest

from app import views
from bspline_slam.measuring import Measurement, PickedControlPoint, PickedPlace, PickedPose
from splinescope.panels.ruler import figures, reading
from splinescope.ruler import Ruler, picked_from, places
from splinescope.view import Selection


def test_a_selection_stands_for_a_thing_to_measure_from() -> None:
    view = views.office(np.random.default_rng(1))
    assert view.map is not None and view.scan is not None
    spline = view.map.map[2]
    t = 0.3 * spline.span[0] + 0.7 * spline.span[1]
    near = spline.curve(np.array([t]))[0] + 0.01
    picked = picked_from(Selection("spline", 2), view.scan, view.map, near)
    assert isinstance(picked, PickedPlace) and picked.t == pytest.approx(t, abs=0.03)
    assert picked_from(Selection("spline", 2), view.scan, view.map) == PickedPlace(2, 0.5 * sum(spline.span))
    assert picked_from(Selection("key pose", 3), view.scan, view.map) == PickedPose(3)
    assert picked_from(Selection("control point", 2, 1), view.scan, view.map) == PickedControlPoint(2, 1)
    tied = next(a for a in view.scan.associations if a.spline is not None)
    given = picked_from(Selection("segment", tied.segment), view.scan, view.map)
    assert isinstance(given, PickedPlace) and given.spline == tied.spline
    for nothing in (None, Selection("spline", 999), Selection("closure", 0), Selection("segment", 999)):
        assert picked_from(nothing, view.scan, view.map) is None


def test_the_ruler_lies_where_its_things_are() -> None:
    world = views.map_view(np.random.default_rng(1))
    ruler = Ruler().picking(PickedPose(4)).picking(PickedControlPoint(2, 1))
    ends = np.array([world.key_poses[4, :2], world.map[2].curve.control_points[1]])
    assert places(ruler, world) == pytest.approx(ends)
    gone = Ruler(PickedPose(4), PickedPlace(999, 0.0))
    assert places(gone, world).shape == (1, 2)
    assert places(Ruler(), world).shape == (0, 2)


def test_the_panel_leads_from_thing_to_thing() -> None:
    ruler = Ruler()
    assert "first thing" in "".join(reading(ruler))
    ruler = ruler.picking(PickedPose(4))
    assert "robot at key scan 4" in "".join(reading(ruler)) and "second thing" in "".join(reading(ruler))
    ruler = ruler.picking(PickedPlace(7, 0.0))
    assert "Measuring" in "".join(reading(ruler))
    assert ruler.picking(PickedPose(1)) == Ruler(PickedPose(1))
    assert dict(figures(Measurement(1.23456, 0.0012, np.pi / 2, np.radians(0.2)))) == {
        "distance": "1.2346 m ± 1.2 mm (1σ)",
        "angle": "90.00° ± 0.20° (1σ)",
    }
    assert dict(figures(Measurement(0.0, None))) == {"distance": "0.0000 m"}
