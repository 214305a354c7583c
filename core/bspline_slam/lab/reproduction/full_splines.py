"""The paper's way to a map of clamped splines (section 4): each new sight of a spline is the full spline again, a
part of it, or an extension; what has been seen so far counts as the whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.fitting import FittingConfig, chord_length_parameters, fit_parameters
from bspline_slam.graph import Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor
from bspline_slam.lab.reproduction.sight import CONTROL_POINTS
from bspline_slam.models import ChordLength
from bspline_slam.observation import ChordLengthNoise, chord_length
from bspline_slam.relation import Relation, extended

NOISE, ADJUSTMENT = ChordLengthNoise(), AdjustmentConfig()


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """What one pose saw of one spline: points in the robot's frame, in order along it, and where the laser sits."""

    pose: int
    spline: int
    points: Float[np.ndarray, "m 2"]
    sensor: Float[np.ndarray, "2"]


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """A sight and the parameters of its points on the full spline, and how it was found to lie on it at first."""

    sight: Sight
    parameters: Float[np.ndarray, "m"]
    relation: Relation


@dataclass(frozen=True, eq=False, slots=True)
class FullSplines:
    """The curve of each spline by id (world frame, domain [0, 1]) and all sights placed on them."""

    curves: dict[int, BSpline]
    placed: tuple[Placed, ...]

    @property
    def first(self) -> dict[int, int]:
        """Where the control points of each spline begin when all are stacked by id."""
        return {spline: CONTROL_POINTS * k for k, spline in enumerate(sorted(self.curves))}


def grown(sights: Sequence[Sight], poses: Float[np.ndarray, "n 3"], fitting: FittingConfig) -> FullSplines:
    """Take in sights one after another at these poses; those whose bearings do not tell where they lie on
    their spline are left out."""
    model = ChordLength(fitting)
    curves: dict[int, BSpline] = {}
    placed: list[Placed] = []
    for sight in sights:
        laser = se2.compose(poses[sight.pose], np.array([*sight.sensor, 0.0]))
        points, spline = sight.points - sight.sensor, sight.spline
        if spline not in curves:
            t = chord_length_parameters(points)
            first = fit_parameters(points, t, clamped_knots(CONTROL_POINTS), fitting).curve
            curves[spline] = first.moved(laser)
            placed.append(Placed(sight, t, Relation.FULL))
            continue
        known = curves[spline].moved(se2.inverse(laser))
        decision = model.related(known, points)
        if decision is None:
            continue
        if decision.relation is Relation.EXTENSION:
            curves[spline] = extended(known, points, decision, CONTROL_POINTS, fitting).moved(laser)
        placed.append(Placed(sight, decision.parameters(points), decision.relation))
    return _on_unit_domain(curves, placed)


def _on_unit_domain(curves: Mapping[int, BSpline], placed: Sequence[Placed]) -> FullSplines:
    """Full splines that have grown, and all that was placed on them, with parameters from 0 to 1 again."""
    start = {spline: curve.domain[0] for spline, curve in curves.items()}
    scale = {spline: 1.0 / (curve.domain[1] - curve.domain[0]) for spline, curve in curves.items()}
    return FullSplines(
        {
            spline: BSpline(curve.degree, (curve.knots - start[spline]) * scale[spline], curve.control_points)
            for spline, curve in curves.items()
        },
        tuple(
            replace(one, parameters=(one.parameters - start[one.sight.spline]) * scale[one.sight.spline])
            for one in placed
        ),
    )


def observation(full: FullSplines, one: Placed, fitting: FittingConfig) -> SplineFactor:
    """The control points of the full spline as one sight gives them (eqs 8–15)."""
    spline, sensor = one.sight.spline, one.sight.sensor
    t = np.clip(one.parameters, *full.curves[spline].domain)
    seen = chord_length(full.curves[spline], t, one.sight.points - sensor, fitting, NOISE).moved(sensor)
    return SplineFactor(one.sight.pose, full.first[spline] + seen.first, seen.A, seen.b, seen.readings, seen.constant)


def problem(
    full: FullSplines,
    poses: Float[np.ndarray, "n 3"],
    scans: Int[np.ndarray, "n"],
    fitting: FittingConfig,
    odometry: Sequence[PoseFactor] = (),
) -> Graph:
    """Poses and control points with one observation for each sight; control points that no sight reaches are held by
    their neighbours."""
    bend = np.kron(np.array([[1.0, -2.0, 1.0]]), np.eye(2)) / ADJUSTMENT.bend
    ids = np.array(sorted(full.curves))
    return Graph(
        key_scans=scans,
        poses=poses,
        spline_ids=ids,
        spline_first=CONTROL_POINTS * np.arange(len(ids) + 1),
        control_points=np.concatenate([full.curves[spline].control_points for spline in ids.tolist()]),
        spline_factors=tuple(observation(full, one, fitting) for one in full.placed),
        pose_factors=tuple(odometry),
        pose_priors=(PosePrior(0, poses[0], np.eye(3) / ADJUSTMENT.anchor),),
        shape_priors=tuple(
            ShapePrior(first + k, bend, np.zeros(2)) for first in full.first.values() for k in range(CONTROL_POINTS - 2)
        ),
    )


def estimated_curves(full: FullSplines, control_points: Float[np.ndarray, "N 2"]) -> dict[int, BSpline]:
    """The splines by id with these control points, stacked by id."""
    pieces = control_points.reshape(-1, CONTROL_POINTS, 2)
    return {spline: full.curves[spline].with_control_points(pieces[k]) for k, spline in enumerate(full.first)}
