"""The twin of a finished run: its map as the world, its path as the truth, and a log simulated from both."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from bspline_slam import se2
from bspline_slam.bspline import BSpline
from bspline_slam.calibration.odometry import in_step
from bspline_slam.errors import ConfigError
from bspline_slam.lab.casting import Obstacles
from bspline_slam.lab.disturbances import USUAL, DisturbanceModel, Disturbances
from bspline_slam.lab.finished_run import MAP, REPORT, FinishedRun
from bspline_slam.lab.simulation import QUANTUM, OdometryModel, Progress, SimulatedLog, silent
from bspline_slam.lab.twin_laser import TwinLaser
from bspline_slam.scan import LaserScan, Records, ScanLog, increasing_times
from bspline_slam.spline_map import SplineMap

BATCH = 256
"""Scans whose rays are cast together."""
TREMBLE, TREMBLE_TURN = 0.005, float(np.radians(0.2))
"""Steps below these (m, rad) are the noise of the estimate: the robot stood still."""
CLEARANCE, STEP = 0.2, 0.05
"""Nothing stands within this distance of the path of a robot (m), looked for in steps of so much."""


@dataclass(frozen=True, eq=False, slots=True)
class Twin:
    """What is simulated: curves as the world, a path with a pose for every record, the laser, how odometry errs.

    `odometry` is None where the run had none. `lag` is by how many records odometry is behind the scans, `lever` how
    far (m) the poses lie ahead of the wheels' centre of rotation, which odometry tells of.
    """

    name: str
    curves: tuple[BSpline, ...]
    stamps: Float[np.ndarray, "records"]
    poses: Float[np.ndarray, "records 3"]
    scan_of_record: Int[np.ndarray, "records"]
    laser: TwinLaser
    odometry: OdometryModel | None
    lag: float = 0.0
    lever: float = 0.0

    @classmethod
    def from_run(cls, run: FinishedRun, log: ScanLog | None = None) -> Twin:
        """The twin of a run. `log`, the one it was made from, tells exactly which records hold scans and how the laser
        sees; without it both come from the report, and the scans lie evenly among the records.

        Raises ConfigError, with what is missing.
        """
        if len(run.splines) == 0:
            raise ConfigError(f"{run.folder.name}: its {MAP} holds no spline, so there is no world to drive through")
        noted = run.report.get("odometry") or {}
        return cls(
            name=f"twin of {run.report.get('log', {}).get('name', run.folder.name)}",
            curves=tuple(clear_of(run.trajectory.poses, run.splines)),
            stamps=np.round(increasing_times(run.trajectory.stamps), 6),
            poses=without_tremble(run.trajectory.poses),
            scan_of_record=_spread_scans(run) if log is None else log.records.scan_of_record,
            laser=_noted_laser(run) if log is None else TwinLaser.from_scan(log[0]),
            odometry=_odometry_model(noted) if run.report.get("log", {}).get("odometry", True) else None,
            lag=float(noted.get("lag", 0.0)),
            lever=float(noted.get("lever", 0.0)),
        )

    def stretch(self, first: int, last: int) -> Twin:
        """Only scans first … last − 1, and the records between them; raises ConfigError where there are none."""
        scans = int(self.scan_of_record.max()) + 1
        if not 0 <= first < min(last, scans):
            raise ConfigError(f"the {self.name} has scans 0 to {scans - 1}, none from {first} on before {last}")
        last = min(last, scans)
        a, b = (int(np.flatnonzero(self.scan_of_record == scan)[0]) for scan in (first, last - 1))
        kept = slice(a, b + 1)
        numbers = np.where(self.scan_of_record[kept] >= 0, self.scan_of_record[kept] - first, -1)
        return replace(self, stamps=self.stamps[kept], poses=self.poses[kept], scan_of_record=numbers)


def simulate_twin(
    twin: Twin,
    *,
    rng: np.random.Generator,
    noise: float = 0.012,
    bearing_noise: float = 1e-3,
    disturbances: DisturbanceModel = USUAL,
    odometry_noise: float = 1.0,
    progress: Progress = silent,
) -> SimulatedLog:
    """Drive the path once more: ranges in steps of a centimetre, people, blocked scans, odometry with bias and noise.

    `noise` (m) and `bearing_noise` (rad) are standard deviations per beam; `odometry_noise` multiplies every error of
    odometry. `shapes` of the result are numbers of curves, −1 where a beam met none or was stopped before.
    """
    scan_rng, odometry_rng, disturbance_rng = rng.spawn(3)
    places = np.flatnonzero(twin.scan_of_record >= 0)
    stamps, poses = twin.stamps[places], twin.poses[places]
    around = Disturbances.drawn(disturbances, stamps, poses[:, :2], disturbance_rng)
    scans, shapes = [], []
    for ranges, met in _measured(twin, poses, around, scan_rng, noise, bearing_noise):
        scans.append(_scan(twin.laser, len(scans), float(stamps[len(scans)]), ranges))
        shapes.append(met)
        progress(len(scans), len(places))
    reported = None
    if twin.odometry is not None:
        wheels = se2.compose(twin.poses, np.broadcast_to([-twin.lever, 0.0, 0.0], twin.poses.shape))
        reported = in_step(twin.odometry.scaled(odometry_noise).drift(wheels, odometry_rng), -twin.lag)
    records = Records(twin.stamps, increasing_times(twin.stamps), reported, twin.scan_of_record)
    return SimulatedLog(twin.name, tuple(scans), records, twin.poses, tuple(shapes))


def _measured(
    twin: Twin,
    poses: Float[np.ndarray, "scans 3"],
    around: Disturbances,
    rng: np.random.Generator,
    noise: float,
    bearing_noise: float,
) -> Iterator[tuple[Float[np.ndarray, "beams"], Int[np.ndarray, "beams"]]]:
    """Ranges (m; +inf for nothing) and the curves met, scan by scan."""
    laser, world = twin.laser, Obstacles.from_curves(twin.curves)
    beams = len(laser.bearings)
    sensors = se2.compose(poses, np.broadcast_to(laser.pose_robot_sensor, poses.shape))
    for first in range(0, len(poses), BATCH):
        batch = sensors[first : first + BATCH]
        angle = batch[:, 2:] + laser.bearings + bearing_noise * rng.standard_normal((len(batch), beams))
        rays = np.stack([np.cos(angle), np.sin(angle)], -1)
        origins = np.repeat(batch[:, :2], beams, axis=0)
        reach, met = world.hits(origins, rays.reshape(-1, 2), laser.range_max)
        errors = noise * rng.standard_normal(reach.shape).reshape(-1, beams)
        for k, sensor in enumerate(batch):
            beam = slice(k * beams, (k + 1) * beams)
            shorter, stopped = around.shortened(first + k, reach[beam], sensor[:2], rays[k], rng)
            ranges = np.round((shorter + errors[k]) / QUANTUM) * QUANTUM
            seen = ranges < laser.range_max
            shape = np.where(seen & ~stopped, met[beam], -1)
            yield np.where(seen, np.maximum(ranges, laser.range_min), np.inf), shape


def _scan(laser: TwinLaser, index: int, stamp: float, ranges: Float[np.ndarray, "beams"]) -> LaserScan:
    return LaserScan(index, stamp, ranges, laser.bearings, laser.range_min, laser.range_max, laser.pose_robot_sensor)


def without_tremble(poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """The path with every pose that lies within the noise of the one before it put onto that one: a robot at rest."""
    still, last = poses.copy(), 0
    for k in range(1, len(poses)):
        step = se2.between(still[last], poses[k])
        if np.hypot(step[0], step[1]) < TREMBLE and abs(step[2]) < TREMBLE_TURN:
            still[k] = still[last]
        else:
            last = k
    return still


def clear_of(path: Float[np.ndarray, "n 3"], splines: SplineMap) -> Iterator[BSpline]:
    """The supported stretches of all splines without what lies within CLEARANCE of the path: a door that stood there
    was open, and somebody who stood there was gone, when the robot came through."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1))])
    places = np.arange(0.0, way[-1] + STEP, STEP)
    tree = KDTree(np.stack([np.interp(places, way, path[:, axis]) for axis in (0, 1)], -1))
    for spline in splines:
        t, points = spline.sample(STEP)
        free = tree.query(points)[0] > CLEARANCE
        edges = np.flatnonzero(np.diff(free, prepend=False, append=False))
        for first, end in edges.reshape(-1, 2):
            if end - first > 1:
                yield spline.curve.clamped((float(t[first]), float(t[end - 1])))


def _odometry_model(noted: dict[str, Any]) -> OdometryModel:
    """Odometry that errs as the calibration of the run says; what that does not tell is as in any simulation."""
    usual = OdometryModel()
    scale, turn_scale = noted.get("distance_scale"), noted.get("turn_scale")
    if not scale or not turn_scale:
        return usual
    return replace(
        usual,
        scale=1.0 / scale - 1.0,
        turn_scale=1.0 / turn_scale - 1.0,
        turn_bias=-float(noted.get("turn_per_metre", 0.0)) / (scale * turn_scale),
    )


def _noted_laser(run: FinishedRun) -> TwinLaser:
    try:
        return TwinLaser.from_dict(run.report["laser"])
    except (KeyError, TypeError, ValueError):
        raise ConfigError(
            f"{run.folder.name}: its {REPORT} does not tell how the laser sees; the log it was made from is needed too"
        ) from None


def _spread_scans(run: FinishedRun) -> Int[np.ndarray, "records"]:
    """As many scans as the run had, evenly among the records; every record where the report does not tell."""
    records = len(run.trajectory)
    scans = min(int(run.report.get("log", {}).get("scans", records)), records)
    if scans < 1:
        raise ConfigError(f"{run.folder.name}: its {REPORT} tells of a log without a scan")
    numbers = np.full(records, -1)
    numbers[np.arange(scans) * records // scans] = np.arange(scans)
    return numbers
