"""What a run was and how it went, as plain data: `report.json`."""

from __future__ import annotations

import platform
import resource
import sys
from collections import Counter
from dataclasses import asdict
from importlib.metadata import version
from time import process_time
from typing import Any

from bspline_slam.backends.protocol import Estimate
from bspline_slam.calibration.odometry import odometry_bias
from bspline_slam.calibration.open_steps import open_steps
from bspline_slam.config import config_to_dict
from bspline_slam.lab.residuals import BeamResiduals
from bspline_slam.lab.twin_laser import TwinLaser
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamConfig, SlamResult, Snapshot

PACKAGES = ("splinescope", "numpy", "scipy", "numba", "gtsam", "kiss-icp", "rosbags")


def report(log: ScanLog, config: SlamConfig, result: SlamResult, seconds: dict[str, float]) -> dict[str, Any]:
    """Configuration, counts, scans that were lost, whose odometry was not believed, and that nothing told the way to,
    fit, calibration, wall times by stage and processor time of all (s), memory (MB) of one run over `log`."""
    snapshot = result.snapshot
    return {
        "format": "splinescope-report",
        "version": 1,
        "log": _log(log),
        "laser": TwinLaser.from_scan(log[0]).to_dict(),
        "counts": _counts(snapshot),
        "lost_scans": list(result.lost),
        "odometry_unfit_scans": list(result.unfit),
        "open_scans": list(open_steps(snapshot.pose_factors, snapshot.key_scans)),
        **(_fit(snapshot.estimate) if snapshot.estimate else {}),
        "odometry": _odometry(log, snapshot),
        "laser_calibration": snapshot.laser.to_dict(),
        "range_noise": _range_noise(snapshot, config),
        "seconds": {stage: round(time, 3) for stage, time in seconds.items()},
        "seconds_total": round(sum(seconds.values()), 3),
        "processor_seconds": round(process_time(), 1),
        "peak_memory_mb": round(peak_memory_mb(), 1),
        "versions": {"python": platform.python_version()} | {name: version(name) for name in PACKAGES},
        "configuration": config_to_dict(config),
    }


def peak_memory_mb() -> float:
    """The most memory that this process and those it waited for have held (MB)."""
    unit = 1 if sys.platform == "darwin" else 1024
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return max(resource.getrusage(each).ru_maxrss for each in who) * unit / 1e6


def _log(log: ScanLog) -> dict[str, Any]:
    times = log.records.times
    return {
        "name": log.name,
        "content_hash": log.content_hash,
        "records": len(times),
        "scans": len(log),
        "seconds": round(float(times[-1] - times[0]), 3),
        "odometry": log.odometry is not None,
        "notes": list(log.notes),
    }


def _odometry(log: ScanLog, snapshot: Snapshot) -> dict[str, Any] | None:
    """The calibration of odometry that the estimate implies; None where it tells none."""
    bias = odometry_bias(log.records, snapshot.poses)
    return None if bias is None else {name: round(value, 4) for name, value in asdict(bias).items()}


def _range_noise(snapshot: Snapshot, config: SlamConfig) -> dict[str, float | None]:
    """Standard deviation of ranges (m) as configured and as the residuals tell it; null where they are too few."""
    estimated = BeamResiduals.from_snapshot(snapshot, config.fitting).range_noise
    return {
        "configured": config.fitting.range_noise,
        "estimated": None if estimated is None else round(estimated, 5),
    }


def _counts(snapshot: Snapshot) -> dict[str, Any]:
    verdicts = Counter(decision.verdict.value for step in snapshot.steps for decision in step.associations)
    closures = Counter(closure.verdict for closure in snapshot.loop_closures)
    return {
        "scans": len(snapshot.poses),
        "key_scans": len(snapshot.key_scans),
        "splines": len(snapshot.map),
        "control_points": snapshot.map.control_point_count,
        "spline_metres": round(sum(spline.length for spline in snapshot.map), 2),
        "associations": dict(sorted(verdicts.items())),
        "loop_closures": {verdict: closures[verdict] for verdict in ("accepted", "rejected", "waiting")},
    }


def _fit(estimate: Estimate) -> dict[str, Any]:
    return {
        "converged": estimate.converged,
        "iterations": len(estimate.iterations) - 1,
        "cost_before": estimate.iterations[0].cost,
        "cost_after": estimate.iterations[-1].cost,
        "chi2": estimate.chi2,
        "dof": round(estimate.dof),
        "chi2_per_dof": estimate.chi2 / estimate.dof if estimate.dof > 0 else None,
    }
