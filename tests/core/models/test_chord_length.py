"""The paper's model: how many control points, what a segment makes of its spline, what an observation claims."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.association import Association, AssociationConfig, Verdict
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig
from bspline_slam.front_end.mapping import MapBuilder
from bspline_slam.graph import SplineFactor
from bspline_slam.models import ChordLength, ChordLengthConfig
from bspline_slam.models.protocol import SeenBeams
from bspline_slam.relation import Relation
from bspline_slam.segmentation import EndKind, ScanSegment

MODEL = ChordLength()
HERE, CENTRE = np.zeros(3), np.zeros(2)
EXACT = ChordLength(FittingConfig(stiffness=np.inf))


def arc(first: float, last: float, step: float = 0.5, radius: float = 3.0) -> np.ndarray:
    """Points of a circle around the origin, from bearing to bearing (degrees)."""
    angle = np.radians(np.arange(first, last + 1e-9, step))
    return radius * np.stack([np.cos(angle), np.sin(angle)], -1)


def segment(points: np.ndarray, scan: int = 0) -> ScanSegment:
    return ScanSegment(scan, 0, np.arange(len(points)), points, EndKind.EDGE, EndKind.EDGE)


def grown(*seen: np.ndarray, sensor: np.ndarray = CENTRE) -> tuple[MapBuilder, list[Association]]:
    """The map after these runs of points, one a scan, and the decision about each."""
    builder = MapBuilder(AssociationConfig(), MODEL)
    decided = [builder.add(k, HERE, [segment(points, k)], sensor) for k, points in enumerate(seen)]
    return builder, [one for (one,) in decided]


def observed(curve: BSpline, pose: np.ndarray, points: np.ndarray, sensor: np.ndarray) -> SplineFactor | None:
    m, nothing = len(points), np.zeros((len(points), 2))
    beams = SeenBeams(
        np.array([0, m]), sensor[None], points, np.zeros(m, np.int64), np.zeros((m, 4)), nothing, nothing[:, 0],
        nothing[:, 0] + 1.0,
    )  # fmt: skip
    return next(iter(EXACT.observe([curve], pose[None], beams)), None)


@pytest.mark.parametrize(("points", "count"), [(60, 13), (26, 13), (20, 10), (8, 4), (3, 4)])
def test_thirteen_control_points_or_one_for_two_points(points: int, count: int) -> None:
    through = MODEL.through(np.stack([np.linspace(0.0, 2.0, points), np.zeros(points)], -1))
    assert len(through.control_points) == count


def test_control_points_are_those_of_the_unit_interval() -> None:
    """Parameters in metres instead of shares change nothing (eqs 4–10)."""
    points = arc(20, 100)
    curve = EXACT.through(points)
    share = curve.with_control_points(curve.control_points)
    B = BSpline(3, share.knots / share.domain[1], share.control_points).basis(
        np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]) / share.domain[1]
    )
    np.testing.assert_allclose(curve.control_points, np.linalg.lstsq(B, points, rcond=None)[0], atol=1e-9)


@pytest.mark.parametrize(
    ("seen", "verdict", "relation"),
    [
        ((30, 100), Verdict.MATCHED, Relation.FULL),
        ((45, 80), Verdict.MATCHED, Relation.PART),
        ((20, 100), Verdict.EXTENDED, Relation.EXTENSION),
        ((50, 130), Verdict.EXTENDED, Relation.EXTENSION),
    ],
)
def test_bearings_decide_what_a_segment_is_to_its_spline(
    seen: tuple[float, float], verdict: Verdict, relation: Relation
) -> None:
    builder, (_, decided) = grown(arc(30, 100), arc(*seen))
    (spline,) = builder.map
    assert (decided.verdict, decided.relation, decided.spline) == (verdict, relation, spline.id)
    assert len(spline.curve.control_points) == 13
    covered = min(30, seen[0]), max(100, seen[1])
    assert spline.length == pytest.approx(3.0 * np.radians(covered[1] - covered[0]), rel=0.01)
    ends = spline.curve(np.array(spline.curve.domain))
    np.testing.assert_allclose(ends, arc(*covered, step=covered[1] - covered[0]), atol=0.02)


def test_one_observation_is_all_that_a_segment_shows_of_a_spline() -> None:
    _, (_, decided) = grown(arc(30, 100), arc(50, 130))
    assert (decided.first, decided.last) == (0, 160)


def test_a_spline_of_few_control_points_has_all_once_it_has_grown() -> None:
    builder, _ = grown(arc(30, 38, 1.0), arc(30, 100))
    assert [len(spline.curve.control_points) for spline in builder.map] == [13]


def test_bearings_are_those_of_the_sensor() -> None:
    """From where the sensor sits, an end that lies beyond by less than the threshold angle at the robot is beyond."""
    at_robot, (_, decided) = grown(arc(30, 100), arc(29.2, 100, 0.4))
    assert decided.relation is Relation.FULL
    _, (_, decided) = grown(arc(30, 100), arc(29.2, 100, 0.4), sensor=np.array([2.0, 1.0]))
    assert decided.relation is Relation.EXTENSION
    assert len(at_robot.map) == 1


def test_what_thirteen_control_points_cannot_follow_starts_a_spline_of_its_own() -> None:
    x = np.arange(-1.0, 6.0, 0.04)
    wave = np.stack([x, 3.0 + 0.25 * np.sin(6.0 * x)], -1)[::-1]  # the robot on the left
    builder = MapBuilder(AssociationConfig(), MODEL)
    for scan, first in enumerate((100, 60, 20, 0)):
        builder.add(scan, HERE, [segment(wave[first:], scan)])
    assert len(builder.map) > 1
    assert all(len(spline.curve.control_points) <= 13 for spline in builder.map)


@pytest.mark.parametrize("sensor", [(0.0, 0.0), (0.3, -0.2)])
@pytest.mark.parametrize("stretch", [(30, 100), (45, 80)])
def test_exact_data_give_the_control_points_of_the_full_spline(
    stretch: tuple[float, float], sensor: tuple[float, float]
) -> None:
    curve, pose = EXACT.through(arc(30, 100, 0.1)), np.array([0.4, -0.3, 0.7])
    points = se2.transform(se2.inverse(pose), arc(*stretch))
    seen = observed(curve, pose, points, np.array(sensor))
    assert seen is not None
    assert seen.readings == len(points)
    true = se2.transform(se2.inverse(pose), curve.control_points)
    true = true[seen.first : seen.first + seen.A.shape[1] // 2]
    assert np.linalg.norm(seen.A @ true.ravel() - seen.b) < 1.0


def test_beams_beyond_the_full_spline_are_left_out() -> None:
    curve = EXACT.through(arc(30, 100, 0.1))
    seen = observed(curve, HERE, arc(20, 100), CENTRE)
    assert seen is not None
    assert 138 <= seen.readings <= 143
    assert observed(curve, HERE, arc(30, 31), CENTRE) is None


def test_an_end_that_only_seems_to_coincide_makes_no_observation() -> None:
    """The curve goes on along the beam past the end of the data: less than the threshold angle, but a metre."""
    bend = arc(30, 60, 0.5)
    away = bend[-1] + np.linspace(0.02, 1.2, 40)[:, None] * bend[-1] / np.linalg.norm(bend[-1])
    curve = EXACT.through(np.concatenate([bend, away]))
    assert observed(curve, HERE, bend, CENTRE) is None
    generous = ChordLength(EXACT.fitting, ChordLengthConfig(gate=10.0))
    assert generous.related(curve, bend) is not None
