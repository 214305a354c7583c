"""Measuring in a map: distance and angle between two picked things, with the uncertainty that all of the map leaves.

Notation: p and τ are the place and the unit direction of a thing, n its normal, κ the curvature of a curve, H the
Gauss-Newton matrix of the whole problem. Any row vector J of derivatives has the variance J H⁻¹ Jᵀ, correlations
between the two things included; a place on a wall has what its curve leaves out beside that.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.protocol import Estimate
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.bspline import BSpline, basis_rows
from bspline_slam.errors import SolverError
from bspline_slam.graph import Graph
from bspline_slam.spline_map import SplineMap


@dataclass(frozen=True, slots=True)
class PickedPose:
    """The robot at the key scan of this index: its direction is its heading."""

    scan: int


@dataclass(frozen=True, slots=True)
class PickedPlace:
    """Where a curve passes parameter t: its direction is the tangent, which has no sense.

    A curve only tells where it lies across itself: the place moves along its normal and nowhere else.
    """

    spline: int
    t: float


@dataclass(frozen=True, slots=True)
class PickedControlPoint:
    """A control point of a spline; it has no direction."""

    spline: int
    number: int


Picked = PickedPose | PickedPlace | PickedControlPoint


@dataclass(frozen=True, slots=True)
class Measurement:
    """Distance (m) and angle (rad) between two things, each with its standard deviation; None where there is none.

    The angle turns the first direction into the second; between tangents, which have no sense, it lies in
    (−π/2, π/2].
    """

    distance: float
    distance_sigma: float | None
    angle: float | None = None
    angle_sigma: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Thing:
    """A picked thing at the estimate: its place (m), its direction (rad, None where it has none; `sense` if it differs
    from its opposite), and their derivatives by all unknowns. `own` is the covariance (m²) of the place that no unknown
    has a part in: what a curve leaves out of its wall."""

    place: Float[np.ndarray, "2"]
    place_by: Float[np.ndarray, "2 u"]
    direction: float | None = None
    direction_by: Float[np.ndarray, "u"] | None = None
    sense: bool = True
    own: Float[np.ndarray, "2 2"] = field(default_factory=lambda: np.zeros((2, 2)))


def factorised(estimate: Estimate) -> Factor:
    """The factor of H at an estimate: needed once for any number of measurements."""
    problem = FullProblem.from_graph(estimate.graph)
    return problem.linearise(State(estimate.poses, estimate.control_points)).factorise()


def measure(estimate: Estimate, splines: SplineMap, factor: Factor, first: Picked, second: Picked) -> Measurement:
    """Distance and angle between two things of the map of an estimate.

    Raises SolverError where one of them is not part of what was solved.
    """
    a, b = (thing_of(estimate, splines, picked) for picked in (first, second))
    gap = b.place - a.place
    distance = float(np.linalg.norm(gap))
    if distance == 0.0:
        return Measurement(0.0, None)
    rows = [gap / distance @ (b.place_by - a.place_by)]
    angle = None
    if a.direction is not None and b.direction is not None:
        angle = b.direction - a.direction
        angle = float(se2.wrap(angle) if a.sense and b.sense else 0.5 * se2.wrap(2.0 * angle))
    if a.direction_by is not None and b.direction_by is not None:
        rows.append(b.direction_by - a.direction_by)
    stacked = np.stack(rows, axis=1)
    variances = np.einsum("uk,uk->k", stacked, factor.solve(stacked))
    variances[0] += gap @ (a.own + b.own) @ gap / distance**2
    sigmas = np.sqrt(np.maximum(variances, 0.0))
    return Measurement(distance, float(sigmas[0]), angle, None if angle is None else float(sigmas[1]))


def thing_of(estimate: Estimate, splines: SplineMap, picked: Picked) -> Thing:
    """A picked thing with its derivatives. Raises SolverError where it is not part of what was solved."""
    match picked:
        case PickedPose(scan=scan):
            return _pose(estimate, scan)
        case PickedPlace(spline=spline, t=t):
            return _place(estimate, _curve(estimate, splines, spline), spline, t, splines[spline].left_out)
        case PickedControlPoint(spline=spline, number=number):
            return _control_point(estimate, spline, number)


def _pose(estimate: Estimate, scan: int) -> Thing:
    found = np.flatnonzero(estimate.graph.key_scans == scan)
    if len(found) == 0:
        raise SolverError(f"scan {scan} is not a key scan of what was solved")
    place_by, direction_by = np.zeros((2, estimate.graph.unknowns)), np.zeros(estimate.graph.unknowns)
    column = 3 * int(found[0])
    place_by[:, column : column + 2] = np.eye(2)
    direction_by[column + 2] = 1.0
    pose = estimate.poses[found[0]]
    return Thing(pose[:2], place_by, float(pose[2]), direction_by)


def _control_point(estimate: Estimate, spline: int, number: int) -> Thing:
    column = _column(estimate.graph, spline, number)
    place_by = np.zeros((2, estimate.graph.unknowns))
    place_by[:, column : column + 2] = np.eye(2)
    return Thing(estimate.control_points[(column - 3 * len(estimate.poses)) // 2], place_by)


def _place(estimate: Estimate, curve: BSpline, spline: int, t: float, left_out: float) -> Thing:
    """Where the curve cuts the normal at t: with the curve's own move s along its tangent goes a move of −s/|s′| in t,
    which turns the tangent by −κ s."""
    at = np.array([min(max(t, curve.domain[0]), curve.domain[1])])
    speed, bend = curve(at, 1)[0], curve(at, 2)[0]
    length = float(np.linalg.norm(speed))
    tangent = speed / length
    normal = np.array([-tangent[1], tangent[0]])
    curvature = (speed[0] * bend[1] - speed[1] * bend[0]) / length**3
    moves, turns = (_by_control_points(estimate.graph, curve, spline, at, order) for order in (0, 1))
    direction_by = normal @ turns / length - curvature * (tangent @ moves)
    heading = float(np.arctan2(tangent[1], tangent[0]))
    own = left_out * np.outer(normal, normal)
    return Thing(curve(at)[0], np.outer(normal, normal @ moves), heading, direction_by, sense=False, own=own)


def _by_control_points(
    graph: Graph, curve: BSpline, spline: int, t: Float[np.ndarray, "1"], order: int
) -> Float[np.ndarray, "2 u"]:
    """Derivatives of the curve's point (order 0) or velocity (1) at t by all unknowns."""
    first, weights = basis_rows(curve.knots, curve.degree, t, order)
    by = np.zeros((2, graph.unknowns))
    column = _column(graph, spline, int(first[0]))
    for k, weight in enumerate(weights[0]):
        by[0, column + 2 * k] = by[1, column + 2 * k + 1] = weight
    return by


def _curve(estimate: Estimate, splines: SplineMap, spline: int) -> BSpline:
    """The spline's curve with the control points of the estimate."""
    graph = estimate.graph
    _column(graph, spline, 0)
    number = int(np.flatnonzero(graph.spline_ids == spline)[0])
    mine = estimate.control_points[graph.spline_first[number] : graph.spline_first[number + 1]]
    return splines[spline].curve.with_control_points(mine)


def _column(graph: Graph, spline: int, number: int) -> int:
    """Where the unknowns of a control point begin."""
    found = np.flatnonzero(graph.spline_ids == spline)
    if len(found) == 0:
        raise SolverError(f"spline {spline} is not part of what was solved")
    first, end = graph.spline_first[found[0]], graph.spline_first[found[0] + 1]
    if not 0 <= number < end - first:
        raise SolverError(f"spline {spline} has {end - first} control points, so none of number {number}")
    return 3 * len(graph.poses) + 2 * int(first + number)
