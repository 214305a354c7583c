"""Which part of its full spline a scan saw, by the bearings of the ends (paper, section 4).

All in the frame of the sensor, where a bearing is an angle around the origin. What is on the map of a spline so far
counts as the whole of it, the "full spline"; a new sight of it is the full spline again, a part, or an extension.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam.bspline import BSpline, clamped_between, clamped_knots
from bspline_slam.errors import GeometryError
from bspline_slam.fitting import FittingConfig, chord_length_parameters, cumulated_chords, curve_through


class Relation(Enum):
    """What new data are to the full spline."""

    FULL = "full"
    PART = "part"
    EXTENSION = "extension"


class EndRelation(Enum):
    """Where one end of the data lies, seen from the robot."""

    COINCIDES = "coincides"  # with the end of the full spline, by less than the threshold angle
    INSIDE = "inside"  # the data stop short of the end of the full spline
    BEYOND = "beyond"  # the data go on past it


@dataclass(frozen=True, slots=True)
class RelationConfig:
    """Threshold angle h between ends that coincide, and the resolution of the sensor (rad)."""

    threshold: float = float(np.radians(1.0))
    resolution: float = float(np.radians(0.5))


@dataclass(frozen=True, eq=False, slots=True)
class EndComparison:
    """One end of the data against the same end of the full spline (bearings in rad, sensor frame).

    `turns` is by how many resolutions its beam was turned inwards until it hit the full spline, `hit` the point where
    it did and `parameter` its place on the full spline.
    """

    relation: EndRelation
    data_bearing: float
    spline_bearing: float
    turns: int
    parameter: float
    hit: Float[np.ndarray, "2"]


@dataclass(frozen=True, eq=False, slots=True)
class SplineRelation:
    """New data against the full spline.

    `span` are the parameters of the first and the last datum on the full spline; where the data go beyond it, they
    lie outside its domain by the length seen beyond, as a share of its own length.
    """

    relation: Relation
    start: EndComparison
    end: EndComparison
    span: tuple[float, float]

    def parameters(self, points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
        """Parameter of each datum on the full spline: between the ends by the share of chord length (eqs 8–10)."""
        return self.span[0] + (self.span[1] - self.span[0]) * chord_length_parameters(points)

    def placed(
        self, curve: BSpline, points: Float[np.ndarray, "m 2"]
    ) -> tuple[Float[np.ndarray, "m"], Bool[np.ndarray, "m"]]:
        """Parameter of each datum, and whether it lies on the full spline rather than beyond its ends."""
        low, high = curve.domain
        t = self.parameters(points)
        return t, (t >= low) & (t <= high)


def relate(curve: BSpline, points: Float[np.ndarray, "m 2"], config: RelationConfig) -> SplineRelation:
    """Decide full, part or extension, and the parameters of the two ends of the data.

    `curve` is the full spline and `points` the data, both in the sensor's frame, the points in order along the curve.
    Raises GeometryError when the data pass the full spline without a beam in common, or run against it.
    """
    data = bearings_along(points)
    ends = end_bearings(curve, points, data)
    sense = 1.0 if data[-1] >= data[0] else -1.0
    start = _compare(curve, points[0], float(data[0]), ends[0], sense, config)
    end = _compare(curve, points[-1], float(data[-1]), ends[1], -sense, config)
    span = _end_parameter(curve, points, start, True), _end_parameter(curve, points, end, False)
    if span[0] >= span[1]:
        raise GeometryError("the data end where they begin on the full spline, or run against it")
    low, high = curve.domain
    if span[0] < low or span[1] > high:
        relation = Relation.EXTENSION
    else:
        relation = Relation.FULL if span == (low, high) else Relation.PART
    return SplineRelation(relation, start, end, span)


def extended(
    curve: BSpline, points: Float[np.ndarray, "m 2"], relation: SplineRelation, count: int, fitting: FittingConfig
) -> BSpline:
    """The full spline with what the data add to it: `count` control points on the stretch that both cover.

    What was there keeps its parameters, so the domain grows. Curve and points in one frame.
    """
    low, high = curve.domain
    t, on = relation.placed(curve, points)
    spacing = max(float(np.median(np.linalg.norm(np.diff(points, axis=0), axis=1))), 1e-3)
    old_t, old = curve.sample(spacing)
    every_t, every = np.concatenate([old_t, t[~on]]), np.concatenate([old, points[~on]])
    knots = clamped_between(min(low, relation.span[0]), max(high, relation.span[1]), count, curve.degree)
    return curve_through(every, every_t, knots, fitting)


def bearings_along(points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
    """Bearings of points along a curve, without jumps by 2π (rad)."""
    return np.unwrap(np.arctan2(points[:, 1], points[:, 0]))


def end_bearings(curve: BSpline, points: Float[np.ndarray, "m 2"], data: Float[np.ndarray, "m"]) -> tuple[float, float]:
    """Bearings of the two ends of the full spline, in the same turn as those of the data (rad)."""
    _, samples = curve.sample(0.05)
    along = bearings_along(samples)
    middle = len(points) // 2
    foot = int(np.argmin(np.linalg.norm(samples - points[middle], axis=1)))
    turn = 2 * np.pi * np.round((data[middle] - along[foot]) / (2 * np.pi))
    return float(along[0] + turn), float(along[-1] + turn)


def trace(
    curve: BSpline, datum: Float[np.ndarray, "2"], bearing: float, step: float
) -> tuple[float, int, Float[np.ndarray, "2"]]:
    """Follow the beam of an end of the data from the sensor to the curve, turning it by `step` (rad) until it hits.

    Where a beam crosses the curve more than once, the crossing nearest to the range of the datum counts. Returns the
    parameter of the hit, the number of turns and the point. Raises GeometryError after a whole turn.
    """
    turns = np.arange(int(2 * np.pi / abs(step)) + 1)
    for some in np.split(turns, [1, 16]):  # nearly always the first beam hits
        directions = np.stack([np.cos(bearing + step * some), np.sin(bearing + step * some)], -1)
        ray, ranges, parameters = curve.ray_crossings(np.zeros(2), directions)
        if len(ray):
            hit = int(np.lexsort((np.abs(ranges - np.linalg.norm(datum)), ray))[0])
            return float(parameters[hit]), int(some[ray[hit]]), ranges[hit] * directions[ray[hit]]
    raise GeometryError("no beam in any direction meets the full spline: the sensor stands on it, or it is empty")


def _compare(
    curve: BSpline,
    datum: Float[np.ndarray, "2"],
    data: float,
    spline: float,
    inwards: float,
    config: RelationConfig,
) -> EndComparison:
    """One end: the angle from the end of the full spline inwards to the end of the data decides."""
    inside = inwards * (data - spline)
    relation = EndRelation.INSIDE if inside > 0 else EndRelation.BEYOND
    if abs(inside) <= config.threshold:
        relation = EndRelation.COINCIDES
    parameter, turns, hit = trace(curve, datum, data, inwards * config.resolution)
    return EndComparison(relation, data, spline, turns, parameter, hit)


def _end_parameter(curve: BSpline, points: Float[np.ndarray, "m 2"], end: EndComparison, is_start: bool) -> float:
    """The parameter of one end of the data; lengths beyond the common beam are those of curves, free of noise."""
    low, high = curve.domain
    if end.relation is EndRelation.COINCIDES:
        return low if is_start else high
    if end.relation is EndRelation.INSIDE:
        return end.parameter
    seen = _length_beyond(points, float(np.arctan2(end.hit[1], end.hit[0])), is_start)
    share = seen * (high - low) / max(curve.length(), 1e-9)
    return end.parameter - share if is_start else end.parameter + share


def _length_beyond(points: Float[np.ndarray, "m 2"], bearing: float, is_start: bool) -> float:
    """Length of the data from their end to the beam of this bearing (m), measured on a curve through them."""
    along = bearings_along(points)
    bearing += 2 * np.pi * np.round((along[len(along) // 2] - bearing) / (2 * np.pi))
    sense = 1.0 if along[-1] >= along[0] else -1.0
    share = np.interp(sense * bearing, np.maximum.accumulate(sense * along), chord_length_parameters(points))
    count = max(4, min(len(points) // 3, int(cumulated_chords(points)[-1] / 0.4) + 3))
    smooth = curve_through(points, chord_length_parameters(points), clamped_knots(count), FittingConfig())
    return smooth.length((0.0, float(share)) if is_start else (float(share), 1.0))
