"""What is drawn of hand edits: places that are held, and loop closures."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app import views
from bspline_slam.edits.edit import CloseLoop, PinPose, PinSpline
from splinescope.edits.proposal import Proposal
from splinescope.ghost_view import ghost_view

NOW: Any = SimpleNamespace(key_scans=np.array([0, 4]), poses=np.arange(15.0).reshape(5, 3))
CLOSED = CloseLoop(0, 4, (1.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), 1.0, 1.0)


def test_a_pin_is_stuck_where_a_pose_or_a_spline_is_held_last() -> None:
    spline = views.floor_map().splines[0]
    held = PinSpline.at(spline.id, spline.curve, spline.span)
    seen = ghost_view(None, None, (PinPose(4, (1.0, 2.0, 0.0)), held, PinPose(4, (3.0, 4.0, 0.0))), None, None)
    assert seen is not None
    pose, middle = seen.pins
    assert pose == (3.0, 4.0)
    assert np.linalg.norm(spline.sample(0.01)[1] - middle, axis=1).min() < 0.01


def test_a_proposed_pin_is_drawn_before_it_is_accepted() -> None:
    edits = (PinPose(4, (1.0, 2.0, 0.0)),)
    seen = ghost_view(Proposal(edits, "Pin"), None, (), None, None)
    assert seen is not None
    assert seen.pins == ((1.0, 2.0),)


def test_a_pin_to_what_is_no_curve_is_not_drawn() -> None:
    assert ghost_view(None, None, (PinSpline(3, 3, (0.0, 0.0), ((0.0, 0.0),), (0.0, 1.0)),), None, None) is None


def test_a_loop_closed_by_hand_is_a_line_between_its_scans_once_the_map_has_them() -> None:
    seen = ghost_view(None, None, (CLOSED, CLOSED), None, NOW)
    assert seen is not None
    assert seen.ties == pytest.approx(NOW.poses[[0, 4], :2][None])
    assert ghost_view(None, None, (CLOSED,), None, None) is None


def test_without_edits_nothing_is_drawn() -> None:
    assert ghost_view(None, None, (), None, None) is None
