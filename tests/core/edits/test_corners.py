"""Corners under edits: walls that met go on meeting when the map is solved again, and ends cut off by hand are free."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.adjustment.adjust import adjust_splines
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.corners import Corner, corners_of
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import FIRST_MADE_BY_HAND, Edit, Ignore, PinPose, SplitSpline
from bspline_slam.edits.ground import Ground, middles
from bspline_slam.edits.making import decided
from bspline_slam.edits.settling import settled
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.slam_config import SlamConfig
from core.mapped_room import MODEL, disturbed, seen_from


@pytest.fixture(scope="module")
def ground() -> Ground:
    """A room with corners, solved."""
    start = disturbed(0.03)
    keys, splines, factors = seen_from(start)
    config = AdjustmentConfig()
    after, estimate = adjust_splines(keys, start, splines, factors, config, MODEL, "direct", lambda share, record: None)
    decisions = Decisions(estimate.poses, tuple(keys), after, tuple(factors), ())
    factors_seen = FlatFactors.of(estimate.graph.spline_factors)
    seen = middles(factors_seen, estimate.poses, estimate.control_points)
    return Ground(decisions, estimate, SlamConfig(), MODEL, seen)


def edited(ground: Ground, *edits: Edit) -> Decisions:
    """The decisions with these edits, solved."""
    decisions, skipped = decided(ground, ground.decisions, edits)
    assert skipped == (None,) * len(edits)
    return settled(ground, decisions).ground.decisions


def joints(decisions: Decisions) -> set[tuple[int, int]]:
    return {corner.joint for corner in corners_of(decisions.splines)}


def first_corner(ground: Ground) -> Corner:
    return corners_of(ground.decisions.splines)[0]


def test_walls_that_move_go_on_meeting(ground: Ground) -> None:
    x, y, heading = (ground.decisions.poses[5] + np.array([0.03, -0.02, 0.01])).tolist()
    after = edited(ground, PinPose(5, (x, y, heading)))
    assert joints(after) == joints(ground.decisions)
    moved = [corner.point for corner in corners_of(after.splines)]
    still = [corner.point for corner in corners_of(ground.decisions.splines)]
    assert np.linalg.norm(np.array(moved) - still, axis=1).max() > 1e-4


def test_walls_with_a_piece_less_go_on_meeting(ground: Ground) -> None:
    corner = first_corner(ground)
    piece = max(
        (a for key in ground.decisions.keys[1:] for a in key.associations if a.spline == corner.before),
        key=lambda a: a.last - a.first,
    )
    after = edited(ground, Ignore(piece.scan, piece.segment, piece.first, piece.last))
    assert joints(after) == joints(ground.decisions)


def test_the_part_of_a_split_wall_that_lies_at_the_corner_keeps_it(ground: Ground) -> None:
    corner = first_corner(ground)
    wall = ground.decisions.splines[corner.before]
    x, y = wall.curve(np.array([np.mean(wall.span)]))[0].tolist()
    after = edited(ground, SplitSpline(wall.id, (x, y), FIRST_MADE_BY_HAND))
    others = {joint for joint in joints(ground.decisions) if joint[0] != wall.id}
    assert joints(after) == others | {(FIRST_MADE_BY_HAND, corner.after)}


def test_a_wall_cut_off_by_hand_ends_where_it_is_cut(ground: Ground) -> None:
    corner = first_corner(ground)
    wall = ground.decisions.splines[corner.before]
    x, y = wall.curve(np.array([wall.span[1] - 0.5]))[0].tolist()
    after = edited(ground, SplitSpline(wall.id, (x, y), FIRST_MADE_BY_HAND))
    assert after.splines[wall.id].span[1] == pytest.approx(wall.span[1] - 0.5, abs=0.05)
