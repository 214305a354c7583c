"""What finished poses say about the wheels: the bias of odometry, and by how much it is out of step with the laser."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.scan import Records

LAGS: Float[np.ndarray, "lags"] = np.linspace(-1.0, 1.0, 41)
LEAST_TURN = np.deg2rad(1.0)
LEAST_TURNS = 50
"""Lag shows only while the robot turns: fewer steps than these that turn by so much (rad) say nothing."""
LEAST_GAIN = 0.05
"""Share by which a lag has to lower the error of the steps to be believed."""


@dataclass(frozen=True, slots=True)
class OdometryBias:
    """Odometry against the estimate, over `steps` from scan to scan.

    A step of odometry (ds, dθ) means `distance_scale`·ds and `turn_scale`·dθ + `turn_per_metre`·ds (rad/m). `lever`
    (m) is how far ahead of the wheels' centre of rotation the estimated frame lies. `lag` is by how many records
    odometry is behind the scan it is recorded with (negative: ahead).
    """

    steps: int
    distance_scale: float
    turn_scale: float
    turn_per_metre: float
    lever: float
    lag: float


def odometry_bias(records: Records, scan_poses: Float[np.ndarray, "scans 3"]) -> OdometryBias | None:
    """Least squares over the steps between scans; None without odometry or with fewer steps than unknowns."""
    places = scan_records(records, len(scan_poses))
    if records.odometry is None or len(places) < 5:
        return None
    lag = odometry_lag(records, scan_poses)
    step, made = steps(in_step(records.odometry, lag)[places]), steps(scan_poses)
    good = _ordinary(step, made)
    step, made = step[good], made[good]
    if len(step) < 4 or np.linalg.matrix_rank(step[:, [0, 2]]) < 2:
        return None
    distance = np.linalg.lstsq(step[:, :1], made[:, 0], rcond=None)[0]
    turn = np.linalg.lstsq(step[:, [2, 0]], made[:, 2], rcond=None)[0]
    aside = np.linalg.lstsq(step[:, [2, 0, 1]], made[:, 1], rcond=None)[0]
    return OdometryBias(len(step), float(distance[0]), float(turn[0]), float(turn[1]), float(aside[0]), lag)


def odometry_lag(records: Records, scan_poses: Float[np.ndarray, "scans 3"]) -> float:
    """By how many records odometry is behind the scans, as their turns tell; 0 where they do not tell it."""
    places = scan_records(records, len(scan_poses))
    if records.odometry is None or len(places) < 3:
        return 0.0
    made = steps(scan_poses)
    errors = np.array([_turn_error(steps(in_step(records.odometry, lag)[places]), made) for lag in LAGS])
    best, none = int(np.argmin(errors)), int(np.argmin(np.abs(LAGS)))
    return float(LAGS[best]) if errors[best] < (1.0 - LEAST_GAIN) * errors[none] else 0.0


def in_step(odometry: Float[np.ndarray, "records 3"], lag: float) -> Float[np.ndarray, "records 3"]:
    """Odometry moved by `lag` records along its own path, so that it tells where the robot was at each record."""
    place = np.clip(np.arange(len(odometry)) + lag, 0.0, len(odometry) - 1)
    before = np.minimum(place.astype(np.int64), max(len(odometry) - 2, 0))
    after = np.minimum(before + 1, len(odometry) - 1)
    return se2.interpolate(odometry[before], odometry[after], place - before)


def scan_records(records: Records, scans: int) -> Int[np.ndarray, "k"]:
    """The records that hold one of the first `scans` scans."""
    return np.flatnonzero((records.scan_of_record >= 0) & (records.scan_of_record < scans))


def steps(poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n1 3"]:
    """From each pose to the next, seen from it."""
    return se2.between(poses[:-1], poses[1:])


def _ordinary(step: Float[np.ndarray, "n 3"], made: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, "n"]:
    """Steps that odometry and the estimate agree on to within five times the usual."""
    off = np.abs(np.stack([step[:, 0] - made[:, 0], se2.wrap(step[:, 2] - made[:, 2])], -1))
    return np.all(off <= 5.0 * np.median(off, axis=0) + 1e-6, axis=1)


def _turn_error(step: Float[np.ndarray, "n 3"], made: Float[np.ndarray, "n 3"]) -> float:
    """Mean error (rad) of the turns that scale and bias of odometry leave, over steps that turn."""
    turning = (np.abs(made[:, 2]) > LEAST_TURN) & _ordinary(step, made)
    if turning.sum() < LEAST_TURNS:
        return 0.0
    wheel = step[turning][:, [2, 0]]
    fit = np.linalg.lstsq(wheel, made[turning, 2], rcond=None)[0]
    return float(np.abs(made[turning, 2] - wheel @ fit).mean())
