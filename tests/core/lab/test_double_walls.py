"""Double walls: curves beside longer ones that face the same way, and no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, clamped_between
from bspline_slam.lab.double_walls import double_walls
from bspline_slam.spline_map import MapSpline, SplineMap


def wall(*, start: float, end: float, aside: float = 0.0, turned: float = 0.0) -> MapSpline:
    """A straight wall from `start` to `end` along x, that much aside of it, then turned about the origin; its front
    is on the left."""
    x = np.linspace(start, end, 5)
    points = np.column_stack([x, np.full(5, aside)])
    curve = BSpline(2, clamped_between(0.0, end - start, 5, 2), points).moved(np.array([0.0, 0.0, turned]))
    return MapSpline(0, curve, curve.domain, 0)


def doubles(*walls: MapSpline) -> float:
    return double_walls(SplineMap(tuple(replace(one, id=k) for k, one in enumerate(walls))))


@pytest.mark.parametrize("aside", [0.0, 0.05, -0.07])
def test_of_two_curves_side_by_side_what_the_shorter_has_beside_the_longer_counts(aside: float) -> None:
    assert doubles(wall(start=0.0, end=4.0), wall(start=3.0, end=5.0, aside=aside)) == pytest.approx(1.0, abs=0.03)


def test_each_of_three_curves_in_a_heap_counts_once_but_the_longest() -> None:
    heap = (wall(start=0.0, end=4.0), wall(start=1.0, end=3.0, aside=0.03), wall(start=1.0, end=2.0, aside=-0.03))
    assert doubles(*heap) == pytest.approx(3.0, abs=0.05)


def test_two_faces_of_a_thin_wall_are_no_double() -> None:
    front = wall(start=0.0, end=4.0, aside=0.04)
    back = replace(front, curve=wall(start=0.0, end=4.0).curve.reversed())
    assert doubles(front, back) == 0.0


def test_curves_that_follow_each_other_meet_or_lie_farther_apart_are_no_doubles() -> None:
    long, next_one = wall(start=0.0, end=4.0), wall(start=4.05, end=6.0)
    assert doubles(long, next_one) == 0.0
    assert doubles(long, wall(start=0.0, end=2.0, turned=np.pi / 2)) == 0.0
    assert doubles(long, wall(start=0.0, end=2.0, aside=0.1)) == 0.0


def test_where_the_map_lies_does_not_matter() -> None:
    pair = (wall(start=0.0, end=4.0), wall(start=3.0, end=5.0, aside=0.05))
    there = [one.moved(np.array([5.0, -3.0, 1.0])) for one in pair]
    assert doubles(*there) == pytest.approx(doubles(*pair), abs=0.03)


def test_an_empty_map_has_none() -> None:
    assert double_walls(SplineMap()) == 0.0
