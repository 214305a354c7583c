"""The spline observation in an extended Kalman filter: a baseline, inconsistent wherever linearising early hurts."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.arrival import Arrival
from bspline_slam.backends.information_filter import KeyScanFilter, Observe, Rows, spline_rows
from bspline_slam.graph import Graph


class Ekf(KeyScanFilter):
    """EKF-SLAM: state = current pose and all control points, observations = the spline factors (A, b) of the graph.

    See `information_filter` for what a filter cannot do.
    """

    name = "ekf"

    def observation(self, graph: Graph) -> Observe:
        return observed_factors


def observed_factors(
    arrival: Arrival, pose: Float[np.ndarray, "3"], control_points: Float[np.ndarray, "N 2"]
) -> list[Rows]:
    """All spline factors of one key scan."""
    return [spline_rows(factor, pose, control_points) for factor in arrival.spline_factors]
