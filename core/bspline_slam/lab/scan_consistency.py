"""Is this one estimate honest? Its key scans against the truth, where the log has it, and against each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.protocol import Cancelling, Estimate, never
from bspline_slam.lab.innovations import Progress, innovations, plain_estimate
from bspline_slam.lab.scan_test import ScanTest
from bspline_slam.lab.statistics import nees
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot

Poses = Float[np.ndarray, "scans 3"]


@dataclass(frozen=True, eq=False, slots=True)
class ScanConsistency:
    """NEES of key poses, None without truth, and NIS of key scans."""

    nees: ScanTest | None
    nis: ScanTest


def scan_consistency(
    snapshot: Snapshot,
    config: SlamConfig,
    covariances: Mapping[int, Float[np.ndarray, "3 3"]],
    truth: Poses | None,
    progress: Progress = lambda share: None,
    cancelled: Cancelling = never,
) -> ScanConsistency | None:
    """Both tests of a solved map; None where there is nothing to test.

    `covariances` are those of the key poses, by position among the key scans, `truth` has a pose for each scan of the
    log, in a frame of its own. Raises Cancelled and SolverError.
    """
    if snapshot.estimate is None or len(snapshot.key_scans) < 2 or not snapshot.estimate.graph.spline_factors:
        return None
    errors = None if truth is None else pose_errors(snapshot.estimate, covariances, truth)
    return ScanConsistency(errors, innovations(plain_estimate(snapshot, config, cancelled), progress, cancelled))


def pose_errors(estimate: Estimate, covariances: Mapping[int, Float[np.ndarray, "3 3"]], truth: Poses) -> ScanTest:
    """NEES of each key pose but the first: that one is given, and the truth is moved as a whole so that both agree
    there."""
    scans = estimate.graph.key_scans
    true = se2.compose(estimate.poses[0], se2.between(truth[scans[0]], truth[scans]))
    off = estimate.poses - true
    off[:, 2] = se2.wrap(off[:, 2])
    known = [k for k in range(1, len(scans)) if k in covariances]
    squares, dof = np.array([nees(off[k], covariances[k]) for k in known]).reshape(-1, 2).T
    return ScanTest(scans[known], squares, dof)
