"""Whether a log can be mapped at all, asked before any work is done."""

from __future__ import annotations

import numpy as np
from jaxtyping import Shaped

from bspline_slam.errors import LogError
from bspline_slam.scan import ScanLog

LOOKED_AT = 9
"""So many scans, spread over the log, tell the unit of its readings."""
TOO_FAR = 1000.0
"""Where half of all readings lie beyond this (m), they are none in metres."""


def check_log(log: ScanLog) -> None:
    """Raises LogError for a log without a scan, with times or odometry that are no numbers, or whose readings cannot be
    metres."""
    if len(log) == 0:
        raise LogError(log.path, "it holds no laser scan, so there is nothing to map")
    _check_numbers(log, log.times, "the time")
    if log.odometry is not None:
        _check_numbers(log, log.odometry, "the odometry")
    chosen = np.unique(np.linspace(0, len(log) - 1, LOOKED_AT).astype(int)).tolist()
    scans = [log[k] for k in chosen]
    readings = np.concatenate([scan.ranges[scan.valid] for scan in scans])
    if len(readings) and (usual := float(np.median(readings))) > TOO_FAR:
        raise LogError(
            log.path, f"half of its readings are longer than {usual:.4g} m: they should be metres, and are perhaps "
            "millimetres",
        )  # fmt: skip


def _check_numbers(log: ScanLog, values: Shaped[np.ndarray, "scans *c"], what: str) -> None:
    """LogError naming the first scan where one of the values is none."""
    wrong = np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(1))
    if len(wrong):
        raise LogError(log.path, f"{what} of scan {wrong[0]} is not a number")
