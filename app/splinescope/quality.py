"""How good one result is, measured once by the estimator's process: a few figures and small arrays for the page."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.calibration.odometry import OdometryBias, odometry_bias
from bspline_slam.calibration.open_steps import open_steps
from bspline_slam.lab.crispness import CRISP, Crispness
from bspline_slam.lab.residuals import BeamResiduals
from bspline_slam.lab.stretches import Stretches
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamConfig, Snapshot
from splinescope.closures import moves

BINS = 40
EDGES: Float[np.ndarray, "edges"] = np.linspace(-CRISP, CRISP, BINS + 1)
"""Edges of the histogram of residuals (m)."""


@dataclass(frozen=True, eq=False, slots=True)
class LaserNoise:
    """Standard deviation of ranges (m) as configured, where the estimator starts from, and as the residuals tell it
    (None where they are too few), and the spread of all residuals over that expected of the configured noise."""

    configured: float
    estimated: float | None
    spread: float | None

    @classmethod
    def of(cls, residuals: BeamResiduals, config: SlamConfig) -> LaserNoise:
        return cls(config.fitting.range_noise, residuals.range_noise, residuals.spread)


@dataclass(frozen=True, eq=False, slots=True)
class Quality:
    """How near beams end to the map; `histogram` counts the residuals between EDGES, `stretches` tell them along the
    curves, `moves` how far (m, rad) each loop closure is from the map, `calibration` what beams were corrected by.
    `odometry` and `chi2_per_dof` are None where nothing tells them; `untold` are the key scans that nothing told the
    way to in every direction."""

    crispness: Crispness
    histogram: Int[np.ndarray, "bins"]
    stretches: Stretches
    moves: Float[np.ndarray, "closures 2"]
    laser: LaserNoise
    calibration: LaserCalibration
    odometry: OdometryBias | None
    chi2_per_dof: float | None
    untold: tuple[int, ...]


def quality_of(log: ScanLog, snapshot: Snapshot, config: SlamConfig) -> Quality:
    """Measured at the map of a snapshot, solved or not."""
    residuals, estimate = BeamResiduals.from_snapshot(snapshot, config.fitting), snapshot.estimate
    return Quality(
        crispness=residuals.crispness,
        histogram=np.histogram(residuals.across, EDGES)[0],
        stretches=Stretches.of(snapshot.map, residuals),
        moves=moves(snapshot.loop_closures, snapshot.key_scans, snapshot.poses[snapshot.key_scans]),
        laser=LaserNoise.of(residuals, config),
        calibration=snapshot.laser,
        odometry=odometry_bias(log.records, snapshot.poses),
        chi2_per_dof=None if estimate is None or estimate.dof <= 0 else float(estimate.chi2 / estimate.dof),
        untold=open_steps(snapshot.pose_factors, snapshot.key_scans),
    )
