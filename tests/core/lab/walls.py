"""A small log in a room whose walls are known exactly."""

from __future__ import annotations

import numpy as np

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.lab.disturbances import DisturbanceModel
from bspline_slam.lab.simulation import OdometryModel, SimulatedLog
from bspline_slam.lab.twin import Twin, simulate_twin
from bspline_slam.lab.twin_laser import TwinLaser
from bspline_slam.lab.wall_beams import WallBeams
from bspline_slam.segmentation import SegmentationConfig
from bspline_slam.spline_map import MapSpline, SplineMap

CORNERS = np.array([[-2.0, -2.0], [-2.0, 2.0], [6.0, 2.5], [6.0, -2.0]])
"""Clockwise: the left of each wall is the inside of the room."""


def room() -> SplineMap:
    """Four straight walls of seven control points, seen from inside."""
    share = np.linspace(0.0, 1.0, 7)[:, None]
    ends = zip(CORNERS, np.roll(CORNERS, -1, axis=0), strict=True)
    curves = [BSpline(3, clamped_knots(7), b + share * (a - b)) for a, b in ends]
    return SplineMap(tuple(MapSpline(3 * k + 1, curve, curve.domain, 0) for k, curve in enumerate(curves)))


def drive(noise: float, seed: int = 0) -> SimulatedLog:
    """A metre a second through the room, twelve scans."""
    x = np.linspace(0.0, 3.0, 12)
    poses = np.stack([x, 0.1 * x, 0.2 * x], -1)
    laser = TwinLaser(np.radians(np.arange(-90.0, 90.0)), 0.05, 20.0, np.array([0.1, 0.0, 0.0]))
    curves = tuple(spline.curve for spline in room())
    twin = Twin("room", curves, 0.3 * np.arange(12.0), poses, np.arange(12), laser, OdometryModel())
    nobody = DisturbanceModel(blocked_every=0, person_every=0)
    return simulate_twin(twin, rng=np.random.default_rng(seed), noise=noise, bearing_noise=0.0, disturbances=nobody)


def beams(noise: float, seed: int = 0) -> WallBeams:
    """The beams of all its scans, at their true poses."""
    log = drive(noise, seed)
    everyone = TrackingConfig(distance=0.01)
    return WallBeams.from_log(log, log.true_poses[log.scan_records], everyone, SegmentationConfig(), LaserCalibration())
