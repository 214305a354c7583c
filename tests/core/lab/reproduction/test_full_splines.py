"""Maps of clamped splines as the paper makes them: sights placed on what has been seen so far."""

from __future__ import annotations

import numpy as np

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig
from bspline_slam.lab.reproduction import sight as paper
from bspline_slam.lab.reproduction.full_splines import FullSplines, Sight, estimated_curves, grown, problem
from bspline_slam.relation import Relation

FITTING = FittingConfig()
POSES = np.stack([paper.FIRST_POSE, paper.SECOND_POSE])


def stretch(pose: int, low: float, high: float, sensor: tuple[float, float] = (0.0, 0.0)) -> Sight:
    """What a laser that sits at `sensor` on the robot sees of a stretch of the reference spline, without noise."""
    offset = np.array(sensor)
    laser = se2.compose(POSES[pose], np.array([*sensor, 0.0]))
    points = paper.scan_curve(paper.REFERENCE, laser, paper.COARSE)
    t = paper.REFERENCE.foot_points(se2.transform(laser, points))
    return Sight(pose, 7, points[(t >= low) & (t <= high)] + offset, offset)


def off_reference(curve: BSpline) -> float:
    """Largest distance of a curve to the reference spline (m)."""
    _, points = curve.sample(0.05)
    return float(np.linalg.norm(points - paper.REFERENCE(paper.REFERENCE.foot_points(points)), axis=1).max())


def whole(full: FullSplines) -> BSpline:
    (curve,) = full.curves.values()
    return curve


def test_a_spline_grows_by_what_is_seen_beyond_it_and_earlier_sights_keep_their_place() -> None:
    before = grown([stretch(0, 0.25, 0.7)], POSES, FITTING)
    after = grown([stretch(0, 0.25, 0.7), stretch(1, 0.4, 0.9)], POSES, FITTING)
    assert [one.relation for one in after.placed] == [Relation.FULL, Relation.EXTENSION]
    assert whole(after).length() > whole(before).length() + 0.5
    assert len(whole(after).control_points) == len(whole(before).control_points)
    first, second = (one.parameters for one in after.placed)  # beams run against the reference spline
    assert -1e-9 <= second[0] < first[0] < second[-1] < first[-1] <= 1.0
    assert off_reference(whole(after)) < 0.04


def test_poses_and_curve_come_back_from_a_displaced_start() -> None:
    sights = [stretch(0, 0.1, 0.9), stretch(1, 0.1, 0.9), stretch(1, 0.3, 0.8)]
    full = grown(sights, POSES, FITTING)
    displaced = POSES + np.array([[0.0, 0.0, 0.0], [0.1, -0.05, 0.03]])
    estimate = back_end("islsjf").solve(problem(full, displaced, np.arange(2), FITTING))
    assert np.abs(estimate.poses - POSES).max() < 0.02
    assert off_reference(estimated_curves(full, estimate.control_points)[7]) < 0.03


def test_where_the_laser_sits_changes_nothing_but_where_it_looks_from() -> None:
    sensor = (0.2, -0.1)
    full = grown([stretch(0, 0.1, 0.9, sensor), stretch(1, 0.2, 0.7, sensor)], POSES, FITTING)
    estimate = back_end("islsjf").solve(problem(full, POSES, np.arange(2), FITTING))
    assert np.abs(estimate.poses - POSES).max() < 0.02
    assert off_reference(whole(full)) < 0.02
