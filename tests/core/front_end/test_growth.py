"""Curves that grow: what was there stays, the new stretch follows the beams, in either direction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.association import AssociationConfig
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig, cumulated_chords, uniform_through
from bspline_slam.front_end.growth import largest_distance, left_normals, lengthened, smooth_cuts, sparse_cuts
from bspline_slam.spline_map import MapSpline

FITTING = FittingConfig()


def bent(start: float, end: float, spacing: float = 0.05) -> np.ndarray:
    """A stretch of a gently bent wall by arc position."""
    x = np.arange(start, end, spacing)
    return np.stack([x, 0.1 * np.sin(x)], -1)


def through(points: np.ndarray) -> BSpline:
    return uniform_through(points, FITTING)


def wall(start: float, end: float) -> MapSpline:
    points = bent(start, end)
    return MapSpline(0, through(points), (0.0, float(cumulated_chords(points)[-1])), 0)


@given(st.floats(0.2, 3.0))
def test_growing_forward_keeps_the_curve_and_follows_the_beams(more: float) -> None:
    spline = wall(0.0, 2.0)
    new = bent(2.0, 2.0 + more)
    curve, span = lengthened(spline, new, FITTING, forward=True)
    t = np.linspace(0.0, spline.span[1] - 0.5, 30)
    np.testing.assert_allclose(curve(t), spline.curve(t), atol=2e-3)
    assert span[0] == spline.span[0]
    assert largest_distance(curve, span, new) < 0.02


@given(st.floats(0.2, 3.0))
def test_growing_backward_keeps_parameters_of_what_was_there(more: float) -> None:
    spline = wall(0.0, 2.0)
    new = bent(-more, 0.0)
    curve, span = lengthened(spline, new, FITTING, forward=False)
    t = np.linspace(0.5, spline.span[1], 30)
    np.testing.assert_allclose(curve(t), spline.curve(t), atol=2e-3)
    assert span[1] == pytest.approx(spline.span[1])
    assert span[0] < -0.5 * more
    assert largest_distance(curve, span, new) < 0.02


def test_beams_that_lie_behind_the_end_lengthen_nothing() -> None:
    spline = wall(0.0, 2.0)
    curve, span = lengthened(spline, bent(1.0, 1.5), FITTING, forward=True)
    assert span == spline.span
    assert curve is spline.curve


def test_a_right_angle_is_cut_at_its_corner() -> None:
    arm = np.arange(0.0, 1.5, 0.05)
    points = np.concatenate([np.stack([arm, 0 * arm], -1), np.stack([np.full(30, 1.5), 0.05 + arm[:30]], -1)])
    cuts = smooth_cuts(points, through, 0.03)
    assert any(abs(cut - 30) <= 2 for cut in cuts[1:-1])


def test_a_straight_run_is_not_cut() -> None:
    assert smooth_cuts(bent(0.0, 4.0), through, 0.05) == [0, len(bent(0.0, 4.0))]


def test_a_run_is_cut_where_beams_are_sparse_but_not_where_a_far_wall_makes_them_so() -> None:
    config = AssociationConfig()
    angle = np.deg2rad(np.arange(-10.0, 11.0))
    facing = np.stack([np.full(21, 30.0), 30.0 * np.tan(angle)], -1)
    assert sparse_cuts(facing, config) == [0, 21]
    leaping = np.stack([np.linspace(2.0, 6.0, 11), np.linspace(0.1, 0.2, 11)], -1)
    assert len(sparse_cuts(leaping, config)) > 2


def test_normals_of_a_segment_point_at_the_robot() -> None:
    angle = np.linspace(-1.0, 1.0, 40)
    points = 3.0 * np.stack([np.cos(angle), np.sin(angle)], -1)
    assert ((left_normals(points, np.array([len(points)])) * -points).sum(1) > 0).all()
