"""Is the problem solvable? Every pose and spline must hang, through factors, on a pose with a prior."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bspline_slam.errors import SolverError
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import Graph


def check_anchored(graph: Graph) -> None:
    """Raise SolverError naming the first pose or spline that nothing ties to a pose with a prior."""
    if not graph.pose_priors:
        raise SolverError("no pose has a prior, so nothing says where the map lies in the world")
    n = len(graph.poses)
    sights, between = FlatFactors.of(graph.spline_factors), graph.pose_factors
    seen = n + np.searchsorted(graph.spline_first, sights.first, side="right") - 1
    tails = np.append(sights.pose, np.array([factor.i for factor in between], dtype=np.int64))
    heads = np.append(seen, np.array([factor.j for factor in between], dtype=np.int64))
    count = n + len(graph.spline_ids)
    ties = coo_array((np.ones(len(tails)), (tails, heads)), shape=(count, count))
    _, group = connected_components(ties, directed=False)
    loose = np.flatnonzero(~np.isin(group, group[[prior.pose for prior in graph.pose_priors]]))
    if len(loose) == 0:
        return
    if loose[0] < n:
        raise SolverError(
            f"pose {loose[0]} (scan {graph.key_scans[loose[0]]}) is tied by no chain of factors to a pose with a prior"
        )
    raise SolverError(f"no factor ties spline {graph.spline_ids[loose[0] - n]} to the poses of the map")
