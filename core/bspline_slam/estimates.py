"""Estimates from a snapshot: adjusted again, and how sure it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bspline_slam.adjustment.adjust import adjust_splines
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Cancelling, Marginals, never
from bspline_slam.errors import SolverError
from bspline_slam.progress import StageProgress, quiet
from bspline_slam.scan import ScanLog
from bspline_slam.slam_config import SlamConfig, model_of
from bspline_slam.snapshot import Snapshot


def adjust(
    log: ScanLog,
    snapshot: Snapshot,
    config: SlamConfig,
    name: str,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
) -> Snapshot:
    """The snapshot adjusted again by the back end `name`: key poses and map move, all other scans follow. Raises
    Cancelled."""
    if len(snapshot.steps) == 0:
        raise SolverError(f"{log.name}: there is no key scan yet, so there is nothing to optimise")
    before = np.array([step.pose for step in snapshot.steps])
    splines, estimate = adjust_splines(
        snapshot.observations, before, snapshot.map, snapshot.pose_factors, config.adjustment, model_of(config), name,
        lambda fraction, record: progress("adjustment", fraction, record), cancelled,
    )  # fmt: skip
    steps = tuple(replace(step, pose=pose) for step, pose in zip(snapshot.steps, estimate.poses, strict=True))
    poses = snapshot.poses_with(estimate.poses)
    return replace(snapshot, poses=poses, steps=steps, map=splines, estimate=estimate)


def marginals(
    snapshot: Snapshot,
    name: str = "direct",
    poses: Sequence[int] = (),
    splines: Sequence[int] = (),
    cancelled: Cancelling = never,
) -> Marginals:
    """Marginal covariances of key poses (by position among the key scans) and of splines (by id), world frame.

    Raises SolverError before the first adjustment, and Cancelled.
    """
    if snapshot.estimate is None:
        raise SolverError("covariances come with an adjustment: optimise first")
    known = {int(k) for k in snapshot.estimate.graph.spline_ids}
    wanted = [s for s in splines if s in known]
    return back_end(name).covariances(snapshot.estimate, poses=poses, splines=wanted, cancelled=cancelled)
