"""What the simulation knows: which beam met what, the true curves, and the noise of odometry."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.fitting import FittingConfig
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.lab.consistency import ODOMETRY, key_scans
from bspline_slam.lab.simulation import SimulatedLog, simulate
from bspline_slam.lab.truth import (
    MODEL_ERROR,
    TrueCurves,
    localised,
    shape_samples,
    true_map,
    true_observations,
    true_odometry,
)
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import open_world
from bspline_slam.models import NormalDistance

WORLDS = ["corridor", "three_splines"]


@pytest.fixture(scope="module", params=WORLDS)
def drive(request: pytest.FixtureRequest) -> tuple[World, SimulatedLog, list[int]]:
    """A world, a log of it without rounding errors to speak of, and its key scans."""
    world = open_world(request.param)
    log = simulate(world, rng=np.random.default_rng(1), noise=0.0, bearing_noise=0.0, odometry=ODOMETRY)
    return world, log, key_scans(log, TrackingConfig())


def test_a_ray_ends_on_the_shape_that_it_is_said_to_meet() -> None:
    world = open_world("office")
    samples = list(shape_samples(world))
    angle = 2 * np.pi * np.arange(90) / 90
    rays = np.stack([np.cos(angle), np.sin(angle)], -1)
    _, poses = world.drive.poses(5.0)
    for origin in poses[::4, :2]:
        reach, shapes = world.hits(origin, rays)
        assert np.array_equal(shapes >= 0, np.isfinite(reach))
        for ray, distance, shape in zip(rays, reach, shapes, strict=True):
            if shape >= 0:
                assert np.linalg.norm(samples[shape] - (origin + distance * ray), axis=1).min() < 0.005


def test_every_beam_is_given_to_a_curve_that_passes_through_its_end_and_faces_the_robot(
    drive: tuple[World, SimulatedLog, list[int]],
) -> None:
    world, log, scans = drive
    keys = true_observations(world, log, scans)
    faces = sorted({a.spline for key in keys for a in key.associations if a.spline is not None})
    splines = true_map(world, NormalDistance(), faces)
    assert [spline.id for spline in splines] == faces
    poses = log.true_poses[log.scan_records]
    for key in keys:
        for segment, association in zip(key.segments, key.associations, strict=True):
            assert association.spline is not None
            curve = splines[association.spline].curve
            ends = se2.transform(poses[key.scan], segment.points)
            t = curve.foot_points(ends)
            assert np.linalg.norm(curve(t) - ends, axis=1).max() < 0.012
            assert (((poses[key.scan, :2] - curve(t)) * curve.normals(t)).sum(1) > 0).mean() > 0.9
    given = sum(len(segment.beams) for key in keys for segment in key.segments)
    assert given > 0.98 * sum(np.count_nonzero(log[scan].valid) for scan in scans)


def test_true_curves_lie_on_the_truth_and_a_straight_wall_is_one_piece(
    drive: tuple[World, SimulatedLog, list[int]],
) -> None:
    world, _, _ = drive
    curves = TrueCurves.from_world(world)
    splines = true_map(world, NormalDistance(), range(2 * len(list(shape_samples(world)))))
    for spline in splines:
        t, points = spline.sample(0.1)
        assert np.abs(curves.distances(points, spline.curve.normals(t))).max() < 2 * MODEL_ERROR
        if spline.id < 2 * len(world.lines):
            assert len(spline.curve.control_points) == spline.curve.degree + 1


def test_distances_are_measured_along_the_normal_with_its_sign() -> None:
    world = open_world("corridor")
    curves = TrueCurves.from_world(world)
    left_of_the_right_wall = np.array([[3.0, 0.02], [3.0, -0.02]])
    up = np.array([[0.0, 1.0], [0.0, 1.0]])
    assert curves.distances(left_of_the_right_wall, up) == pytest.approx([0.02, -0.02])
    assert curves.distances(left_of_the_right_wall, -up) == pytest.approx([-0.02, 0.02])


def test_odometry_errors_have_the_covariance_that_its_factors_claim() -> None:
    world = open_world("three_splines")
    errors = []
    for seed in range(30):
        log = simulate(world, rng=np.random.default_rng(seed), resolution=np.pi / 4, odometry=ODOMETRY)
        truth = log.true_poses[log.scan_records]
        scans = list(range(0, len(log), 3))
        for edge, (a, b) in zip(true_odometry(log, scans, ODOMETRY), itertools.pairwise(scans), strict=True):
            errors.append(edge.residual(truth[a], truth[b]))
    squares = np.sum(np.square(errors), axis=1)
    assert np.mean(squares) / 3 == pytest.approx(1.0, abs=0.15)


def test_poses_are_found_from_odometry(drive: tuple[World, SimulatedLog, list[int]]) -> None:
    world, log, scans = drive
    keys, odometry = true_observations(world, log, scans), true_odometry(log, scans, ODOMETRY)
    faces = sorted({a.spline for key in keys for a in key.associations if a.spline is not None})
    fitting = FittingConfig()
    truth = log.true_poses[log.scan_records[scans]]
    poses = localised(keys, true_map(world, NormalDistance(fitting), faces), truth[0], odometry, fitting)
    assert np.abs(se2.wrap(poses[:, 2] - truth[:, 2])).max() < 0.01
    assert np.linalg.norm(poses[:, :2] - truth[:, :2], axis=1).max() < 0.2
