"""What edits start from: a solved result with its decisions, its problem, and the noise that its beams show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.protocol import Estimate
from bspline_slam.calibration.laser_noise import calibrated
from bspline_slam.edits.decisions import Decisions
from bspline_slam.errors import SolverError
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.models.protocol import Model
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.slam import SlamConfig, Snapshot, model_of


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """A solved result: its decisions, and the estimate with the problem that they became.

    `model` has the noise that the laser showed in the automatic result. What edits leave alone keeps the factors of
    this problem: it is not linearised anew, so an edit moves nothing but what hangs on it. `seen` is where, seen from
    its pose, the middle control point of each spline factor lay when the factor was linearised.
    """

    decisions: Decisions
    estimate: Estimate
    config: SlamConfig
    model: Model
    seen: Float[np.ndarray, "f 2"]

    @classmethod
    def of(cls, snapshot: Snapshot, config: SlamConfig) -> Ground:
        """That of a finished result. Raises SolverError for one that was never adjusted."""
        if snapshot.estimate is None:
            raise SolverError("edits amend a finished map, and this one was never adjusted")
        return cls.at(Decisions.of(snapshot), snapshot.estimate, config)

    @classmethod
    def at(cls, decisions: Decisions, estimate: Estimate, config: SlamConfig) -> Ground:
        """That of decisions and their estimate, all of it linearised there."""
        model, adjustment = model_of(config), config.adjustment
        if adjustment.estimate_noise and not model.measures_along:
            sights = collect_sights(decisions.keys, decisions.splines)
            feet = find_feet(sights, decisions.splines, decisions.poses, adjustment.gates[-1])
            model = calibrated(model, decisions.splines, sights, feet, decisions.poses)
        factors = FlatFactors.of(estimate.graph.spline_factors)
        return cls(decisions, estimate, config, model, middles(factors, estimate.poses, estimate.control_points))


def middles(
    factors: FlatFactors, poses: Float[np.ndarray, "n 3"], control_points: Float[np.ndarray, "N 2"]
) -> Float[np.ndarray, "f 2"]:
    """The middle control point of each factor, seen from its pose."""
    middle = factors.first + factors.size[:, 1] // 2
    return se2.transform(se2.inverse(poses[factors.pose]), control_points[middle])
