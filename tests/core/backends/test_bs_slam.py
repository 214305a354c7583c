"""Beams of a graph: where they come from, how they are grouped, and what becomes of those that do not fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.bs_slam import GATE, beam_rows, beams_by_pose
from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.errors import SolverError
from bspline_slam.graph import Beams

WALL = BSpline(3, uniform_knots(0.0, 0.5, 9), np.column_stack([0.5 * np.arange(9) - 2.0, np.full(9, 3.0)]))
ALL = np.ones(9, dtype=bool)


def straight_ahead(ranges: np.ndarray) -> Beams:
    """Beams at right angles to a wall 3 m away, side by side."""
    m = len(ranges)
    origins = np.column_stack([np.linspace(-0.5, 0.5, m), np.zeros(m)])
    ones = np.zeros(m, dtype=np.int64)
    directions = np.tile([0.0, 1.0], (m, 1))
    return Beams(ones, ones, origins, directions, ranges, np.full(m, 1.5), np.full(m, 0.01), (WALL,))


def test_a_graph_without_beams_is_refused(world):
    with pytest.raises(SolverError, match="carries none"):
        back_end("bs_slam").solve(world(np.random.default_rng(0)).graph)


def test_residuals_are_ranges_over_their_noise():
    beams = straight_ahead(np.array([2.9, 3.0, 3.05]))
    rows = beam_rows(beams, np.arange(3), se2.IDENTITY, WALL, ALL, 20)
    np.testing.assert_allclose(rows.residual, [10.0, 0.0, -5.0], atol=1e-9)
    np.testing.assert_allclose(rows.by_pose[:, :2], np.tile([0.0, -100.0], (3, 1)), atol=1e-9)
    np.testing.assert_allclose(rows.by_points.reshape(3, -1, 2).sum(1), np.tile([0.0, 100.0], (3, 1)), atol=1e-9)
    assert rows.control_points.min() >= 20


def test_readings_of_something_else_are_left_out():
    beams = straight_ahead(np.array([3.0 - 1.1 * GATE, 3.0 + 0.9 * GATE, 3.0 + 1.1 * GATE]))
    rows = beam_rows(beams, np.arange(3), se2.IDENTITY, WALL, ALL, 0)
    np.testing.assert_allclose(rows.residual, [-90 * GATE])


def test_beams_at_a_stretch_that_has_not_entered_are_left_out():
    beams = straight_ahead(np.full(5, 3.0))
    entered = ALL.copy()
    entered[6:] = False
    rows = beam_rows(beams, np.arange(5), se2.IDENTITY, WALL, entered, 0)
    assert 0 < len(rows.residual) < 5
    assert rows.control_points.max() < 6
    nothing = beam_rows(beams, np.arange(5), se2.IDENTITY, WALL, ~ALL, 0)
    assert nothing.by_points.shape == (0, 0)


def test_groups_hold_every_beam_once():
    rng = np.random.default_rng(1)
    beams = replace(straight_ahead(np.full(40, 3.0)), pose=rng.integers(0, 6, 40), spline=rng.integers(0, 3, 40))
    groups = beams_by_pose(beams, 7)
    assert groups[6] == []
    assert np.array_equal(np.sort(np.concatenate([mine for group in groups for _, mine in group])), np.arange(40))
    for pose, group in enumerate(groups):
        assert len({spline for spline, _ in group}) == len(group)
        for spline, mine in group:
            assert np.all(beams.pose[mine] == pose)
            assert np.all(beams.spline[mine] == spline)
