"""The mistake of the tour: the wall that it mixes up runs beside the right one and is seen from the same side."""

from __future__ import annotations

import numpy as np
import pytest

from app.views import spline_along
from bspline_slam.association import Association, Verdict
from bspline_slam.segmentation import EndKind, ScanSegment
from bspline_slam.slam import SlamStep, Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap
from splinescope.findings import Findings
from splinescope.mistake import FAR, NEAR, mistake_in

RIGHT, WRONG = 0, 1
BEAMS = 40


def findings(away: float, *, turn: bool = False, part: bool = False) -> Findings:
    """A robot at the origin that saw one wall, 3 m ahead; another one runs `away` (m) behind it, or is turned round, or
    stands behind a part of it alone."""
    points = np.column_stack([np.full(BEAMS, 3.0), np.linspace(-1.0, 1.0, BEAMS)])
    wall = np.array([[3.0 + away, -2.0], [3.0 + away, 2.0]])[:: -1 if turn else 1]
    curves = (spline_along(np.array([[3.0, -2.0], [3.0, 2.0]])), spline_along(wall))
    splines = [MapSpline(id, curve, curve.domain, 0, 3) for id, curve in zip((RIGHT, WRONG), curves, strict=True)]
    if part:
        low, high = splines[WRONG].span
        splines[WRONG] = MapSpline(WRONG, curves[WRONG], (low, low + 0.5 * (high - low)), 0, 3)
    seen = Association(0, 0, 0, BEAMS - 1, Verdict.MATCHED, RIGHT, 0.01, 0.1)
    segment = ScanSegment(0, 0, np.arange(BEAMS), points, EndKind.EDGE, EndKind.EDGE)
    step = SlamStep(0, np.zeros(3), np.zeros(3), True, False, 1.0, (segment,), (seen,))
    found = Findings()
    found.record([step])
    found.snapshot = Snapshot(np.zeros((1, 3)), np.array([0]), (step,), SplineMap(tuple(splines)), ())
    return found


def test_a_wall_beside_it_that_faces_the_robot_is_mixed_up() -> None:
    mistake = mistake_in(findings(0.5))
    assert mistake is not None
    assert (mistake.scan, mistake.segment, mistake.first, mistake.last) == (0, 0, 0, BEAMS - 1)
    assert mistake.spline == WRONG


@pytest.mark.parametrize("away", [0.5 * NEAR, 2.0 * FAR])
def test_the_same_wall_and_one_far_off_are_not(away: float) -> None:
    assert mistake_in(findings(away)) is None


def test_a_wall_seen_from_behind_is_not() -> None:
    assert mistake_in(findings(0.5, turn=True)) is None


def test_a_wall_that_ends_within_the_segment_is_not() -> None:
    assert mistake_in(findings(0.5, part=True)) is None
