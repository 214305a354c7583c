"""BS-SLAM (Pedraza et al. 2007): an extended Kalman filter on ranges along beams, where they meet the curves."""

from __future__ import annotations

import itertools

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.backends.arrival import Arrival, entries
from bspline_slam.backends.beam_model import predict_ranges
from bspline_slam.backends.information_filter import KeyScanFilter, Observe, Rows, spline_rows
from bspline_slam.bspline import BSpline
from bspline_slam.errors import SolverError
from bspline_slam.graph import Beams, Graph

GATE = 0.15
"""Distance across the curve (m) beyond which a reading is not of this stretch of it."""
Group = tuple[int, Int[np.ndarray, "m"]]
"""A spline and its beams from one pose."""


class BsSlam(KeyScanFilter):
    """State = current pose and the control points of all splines so far; each beam is an observation of one curve.

    A spline grows in the state as its control points come into sight. Beams that graze a curve, miss it, or meet a
    stretch that is not in the state yet are left out. Of the spline factors only those of no readings are used: they
    fix the parametrisation of the curves. Needs a graph with beams. See `information_filter` for what a filter
    cannot do.
    """

    name = "bs_slam"

    def observation(self, graph: Graph) -> Observe:
        """The beams of each key scan. Raises SolverError for a graph that carries none."""
        if graph.beams is None:
            raise SolverError("BS-SLAM measures along single beams, and this problem carries none")
        beams, enters = graph.beams, entries(graph)
        groups = beams_by_pose(beams, len(graph.poses))

        def observe(
            arrival: Arrival, pose: Float[np.ndarray, "3"], control_points: Float[np.ndarray, "N 2"]
        ) -> list[Rows]:
            gauges = (factor for factor in arrival.spline_factors if not factor.readings)
            rows = [spline_rows(factor, pose, control_points) for factor in gauges]
            for spline, mine in groups[arrival.pose]:
                begin, end = graph.spline_first[spline], graph.spline_first[spline + 1]
                curve = beams.curves[spline].with_control_points(control_points[begin:end])
                rows.append(beam_rows(beams, mine, pose, curve, enters[begin:end] <= arrival.pose, int(begin)))
            return rows

        return observe


def beams_by_pose(beams: Beams, poses: int) -> list[list[Group]]:
    """For each pose its splines, each with the indices of its beams."""
    groups: list[list[Group]] = [[] for _ in range(poses)]
    order = np.lexsort((beams.spline, beams.pose))
    pose, spline = beams.pose[order], beams.spline[order]
    cuts = np.flatnonzero(np.diff(pose, prepend=-1, append=-1) | np.diff(spline, prepend=-1, append=-1))
    for a, b in itertools.pairwise(cuts):
        groups[pose[a]].append((int(spline[a]), order[a:b]))
    return groups


def beam_rows(
    beams: Beams,
    mine: Int[np.ndarray, "m"],
    pose: Float[np.ndarray, "3"],
    curve: BSpline,
    entered: Bool[np.ndarray, "c"],
    begin: int,
) -> Rows:
    """(predicted − measured range)/σ of the beams that meet what has `entered` of a curve, linearised.

    `begin` is the first control point of the curve among all.
    """
    origins, directions, parameters = beams.origins[mine], beams.directions[mine], beams.parameters[mine]
    found = predict_ranges(curve, pose, origins, directions, parameters)
    columns = found.first[:, None] + np.arange(curve.degree + 1)
    across = np.abs(found.ranges - beams.ranges[mine]) * found.incidence
    kept = np.flatnonzero(found.meets & (across < GATE) & entered[columns].all(axis=1))
    scale, columns = 1.0 / beams.sigma[mine[kept]], columns[kept]
    touched = np.unique(columns)
    by_points = np.zeros((len(kept), len(touched), 2))
    by_points[np.arange(len(kept))[:, None], np.searchsorted(touched, columns)] = found.by_points[kept]
    return Rows(
        begin + touched,
        scale * (found.ranges[kept] - beams.ranges[mine[kept]]),
        scale[:, None] * found.by_pose[kept],
        scale[:, None] * by_points.reshape(len(kept), 2 * len(touched)),
    )
