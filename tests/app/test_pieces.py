"""A box finds the pieces that lie in it, however the picture is turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app import views
from bspline_slam import se2
from splinescope.picking import pick_box, pick_piece
from splinescope.pieces import every_piece, name_of_piece, points_of
from splinescope.view import Layer, ScanView, View


@pytest.fixture(scope="module")
def view() -> View:
    made = views.office(np.random.default_rng(3))
    assert made.scan is not None
    return replace(made, scan=replace(made.scan, key=True), layers=frozenset({Layer.SEGMENTS}))


def scan_of(view: View) -> ScanView:
    assert view.scan is not None
    return view.scan


def box_around(points: np.ndarray, turn: float, air: float = 0.01) -> np.ndarray:
    """The corners of the rectangle around some points that stands askew by `turn`."""
    askew = se2.rotate(np.array([0.0, 0.0, -turn]), points)
    (left, low), (right, high) = askew.min(0) - air, askew.max(0) + air
    corners = np.array([[left, high], [right, high], [right, low], [left, low]])
    return se2.rotate(np.array([0.0, 0.0, turn]), corners)


def test_the_pieces_of_a_scan_share_its_points(view: View) -> None:
    scan = scan_of(view)
    names = list(map(name_of_piece, every_piece(scan)))
    assert len(set(names)) == len(names) > 1
    assert {segment for segment, _, _ in names} == {fitted.segment.index for fitted in scan.segments}


@pytest.mark.parametrize("turn", [0.0, 0.7, -2.3])
def test_a_box_around_a_piece_finds_it_and_one_around_all_finds_all(view: View, turn: float) -> None:
    scan = scan_of(view)
    names = tuple(map(name_of_piece, every_piece(scan)))
    for name in names:
        assert name in pick_box(view, box_around(points_of(name, scan), turn))
    everything = np.concatenate([points_of(name, scan) for name in names])
    assert pick_box(view, box_around(everything, turn)) == names
    assert pick_box(view, box_around(everything, turn) + 100.0) == ()


def test_a_piece_of_which_little_lies_in_the_box_is_left_out(view: View) -> None:
    scan = scan_of(view)
    name = max(map(name_of_piece, every_piece(scan)), key=lambda piece: len(points_of(piece, scan)))
    points = points_of(name, scan)
    assert name not in pick_box(view, box_around(points[: len(points) // 3], 0.0))


def test_a_box_without_extent_holds_nothing(view: View) -> None:
    assert pick_box(view, np.zeros((4, 2))) == ()


def test_only_what_is_shown_of_a_key_scan_is_found(view: View) -> None:
    scan = scan_of(view)
    name = name_of_piece(every_piece(scan)[0])
    points = points_of(name, scan)
    middle = points[len(points) // 2]
    assert pick_piece(view, middle, 0.01) is not None
    assert pick_piece(view, middle + 50.0, 0.01) is None
    for hidden in (replace(view, layers=frozenset()), replace(view, scan=replace(scan, key=False))):
        assert pick_piece(hidden, middle, 0.01) is None
        assert pick_box(hidden, box_around(points, 0.0)) == ()
