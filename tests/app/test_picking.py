"""Clicks find what is drawn under them, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from app import views
from bspline_slam import se2
from splinescope.picking import pick
from splinescope.view import Layer, Selection, View

MAP_ONLY = frozenset({Layer.SPLINES, Layer.CONTROL_POINTS})


@pytest.fixture(scope="module")
def view() -> View:
    return views.office(np.random.default_rng(3))


def test_a_click_on_a_spline_finds_it(view: View) -> None:
    assert view.map is not None
    for spline in view.map.map:
        t = np.mean(spline.span)
        on_it = spline.curve(np.array([t]))[0]
        found = pick(replace(view, layers=frozenset({Layer.SPLINES})), on_it + 0.01, 0.05)
        assert found == Selection("spline", spline.id)


def test_a_click_on_a_control_point_finds_it_where_points_stand_apart(view: View) -> None:
    assert view.map is not None
    spline = view.map.map[4]
    near = pick(replace(view, layers=MAP_ONLY), spline.curve.control_points[3] + 0.01, 0.03)
    assert near == Selection("control point", 4, 3)
    from_afar = pick(replace(view, layers=MAP_ONLY), spline.curve(np.array([0.5]))[0], 1.0)
    assert from_afar is not None
    assert from_afar.kind == "spline"


def test_a_click_on_the_scan_finds_the_segment(view: View) -> None:
    assert view.scan is not None
    for fitted in view.scan.segments:
        points = se2.transform(view.scan.pose, fitted.segment.points)
        found = pick(replace(view, layers=frozenset({Layer.SEGMENTS})), points[len(points) // 2], 0.05)
        assert found == Selection("segment", fitted.segment.index)


def test_the_scan_lies_on_top_of_the_map(view: View) -> None:
    assert view.scan is not None
    points = se2.transform(view.scan.pose, view.scan.segments[0].segment.points)
    both = replace(view, layers=frozenset({Layer.SEGMENTS, Layer.SPLINES}))
    found = pick(both, points[len(points) // 2], 0.1)
    assert found is not None
    assert found.kind == "segment"


def test_a_click_on_the_path_finds_the_key_pose(view: View) -> None:
    assert view.map is not None
    layers = frozenset({Layer.ESTIMATE})
    found = pick(replace(view, layers=layers), view.map.key_poses[7, :2], 0.05)
    assert found == Selection("key pose", view.map.key_scans[7])


def test_nothing_is_found_in_the_open_or_where_nothing_is_shown(view: View) -> None:
    assert view.map is not None
    on_a_wall = view.map.map[2].curve.control_points[4]
    assert pick(view, np.array([-40.0, 3.0]), 0.1) is None
    assert pick(replace(view, layers=frozenset()), on_a_wall, 0.1) is None
    assert pick(View(), on_a_wall, 0.1) is None


def test_the_unsupported_stretch_of_a_curve_is_not_there(view: View) -> None:
    assert view.map is not None
    spline = view.map.map[2]
    cut = replace(spline, span=(spline.span[0], spline.span[0] + 0.8))
    beyond = spline.curve(np.array([spline.span[1] - 0.1]))[0]
    shown = replace(view.map, map=type(view.map.map)((cut,)))
    assert pick(View(map=shown, layers=frozenset({Layer.SPLINES})), beyond, 0.1) is None
