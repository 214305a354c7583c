"""What a simulation knows and an estimator does not: the true curves, which beam met which, what odometry errs by."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.fitting import FittingConfig, cumulated_chords
from bspline_slam.graph import PoseFactor
from bspline_slam.lab.simulation import OdometryModel, SimulatedLog
from bspline_slam.lab.world import World
from bspline_slam.models.protocol import Model
from bspline_slam.relation import Relation
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import EndKind, ScanSegment, SegmentationConfig, breakpoints
from bspline_slam.sights import KeyObservations, collect_sights, find_feet
from bspline_slam.spline_map import MapSpline, SplineMap

SPACING = 0.005
"""Distance (m) between the samples of a true curve; on a radius of 0.3 m they err by 10 µm."""
THINNED = 4
"""Every so many samples are enough to fit a curve to."""
MODEL_ERROR = 1e-4
"""Largest distance (m) of a fitted true curve from the truth, a tenth of what a few scans leave uncertain."""
NEIGHBOURS = 64
AGREEMENT = 0.7
LEAST_BEAMS = 20
"""A face that fewer beams met is not made a spline of."""
SEARCH_GATES = (1.0, 0.5, 0.2, 0.1, 0.1)
"""Largest distances (m) from a curve at which beams count, step by step, while a pose is being found."""
STILL = 1e-6
"""Variance (m², rad²) that odometry keeps where the robot hardly moved."""


@dataclass(frozen=True, eq=False, slots=True)
class TrueCurves:
    """All shapes of a world as samples: the shape of each (counted as in `World.hits`), its place, its unit normal."""

    shape: Int[np.ndarray, "s"]
    points: Float[np.ndarray, "s 2"]
    normals: Float[np.ndarray, "s 2"]
    tree: KDTree

    @classmethod
    def from_world(cls, world: World) -> TrueCurves:
        return cls.from_samples(list(shape_samples(world)))

    @classmethod
    def from_samples(cls, curves: Sequence[Float[np.ndarray, "_ 2"]]) -> TrueCurves:
        """From the points of each curve, SPACING apart."""
        points = np.concatenate(curves)
        normals = np.concatenate([_normals(curve) for curve in curves])
        shape = np.repeat(np.arange(len(curves)), [len(curve) for curve in curves])
        return cls(shape, points, normals, KDTree(points))

    def distances(self, points: Float[np.ndarray, "m 2"], normals: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
        """How far each point lies from the truth along its own normal (m, positive on the side of the normal).

        The truth is the nearest true curve that runs in the direction of the estimate, if one is near at all.
        """
        _, found = self.tree.query(points, k=min(NEIGHBOURS, len(self.points)))
        agrees = np.abs(np.einsum("mkd,md->mk", self.normals[found], normals)) > AGREEMENT
        best = found[np.arange(len(points)), agrees.argmax(axis=1)]
        side = np.sign((self.normals[best] * normals).sum(1))
        return ((points - self.points[best]) * self.normals[best]).sum(1) * np.where(side == 0, 1.0, side)


def shape_samples(world: World) -> Iterator[Float[np.ndarray, "_ 2"]]:
    """Points at most SPACING apart along each line, arc and spline, in the order of `World.hits`."""
    for start, end in world.lines:
        share = np.linspace(0.0, 1.0, _count(float(np.linalg.norm(end - start))))
        yield start + share[:, None] * (end - start)
    for x, y, radius, first, sweep in world.arcs:
        angle = first + np.linspace(0.0, sweep, _count(radius * abs(sweep)))
        yield np.array([x, y]) + radius * np.stack([np.cos(angle), np.sin(angle)], -1)
    for spline in world.splines:
        yield spline.sample(SPACING)[1]


def true_map(world: World, model: Model, faces: Sequence[int]) -> SplineMap:
    """One map spline for each of these faces, with its number as id: the model's plainest curve on the truth.

    Where the model chooses, knots lie as far apart as the truth allows: a straight wall is one piece. Knots that
    nothing needs would let the wall wave with the noise, and every pose that fits the waves would believe to know
    where it is along them.
    Face 2k is shape k seen from its left, face 2k + 1 the same shape seen from its right and run through backwards.
    """
    splines = []
    for shape, points in enumerate(shape_samples(world)):
        for face in {2 * shape, 2 * shape + 1} & set(faces):
            ordered = np.concatenate([points[:-1:THINNED], points[-1:]])[:: -1 if face % 2 else 1]
            length = float(cumulated_chords(ordered)[-1])
            splines.append(MapSpline(face, model.plainest(ordered, MODEL_ERROR), (0.0, length), 0))
    return SplineMap(tuple(splines))


def true_observations(world: World, log: SimulatedLog, key_scans: Sequence[int]) -> tuple[KeyObservations, ...]:
    """The key scans with every beam given to the spline of the face that it met."""
    faces = met_faces(world, log, key_scans)
    met = np.concatenate(faces)
    worthy = np.flatnonzero(np.bincount(met[met >= 0], minlength=1) >= LEAST_BEAMS)
    return tuple(_true_observation(log, scan, face, worthy) for scan, face in zip(key_scans, faces, strict=True))


def met_faces(world: World, log: SimulatedLog, key_scans: Sequence[int]) -> list[Int[np.ndarray, "_"]]:
    """For each beam of these scans the face it met, −1 for none."""
    samples = list(shape_samples(world))
    trees = [KDTree(points) for points in samples]
    normals = [_normals(points) for points in samples]
    poses, faces = log.true_poses[log.scan_records], []
    for index in key_scans:
        scan, face = log[index], np.full(len(log.shapes[index]), -1)
        ends = se2.transform(poses[index], np.nan_to_num(scan.points_robot))
        rays = se2.rotate(poses[index], scan.directions_robot)
        for shape in map(int, np.unique(log.shapes[index][scan.valid])):
            beams = np.flatnonzero((log.shapes[index] == shape) & scan.valid)
            near = trees[shape].query(ends[beams])[1]
            face[beams] = 2 * shape + ((normals[shape][near] * rays[beams]).sum(1) > 0)
        faces.append(face)
    return faces


def _true_observation(
    log: SimulatedLog, index: int, met: Int[np.ndarray, "_"], worthy: Int[np.ndarray, "w"]
) -> KeyObservations:
    """One segment for each unbroken run of beams that met a face: chords across a gap would be no measure of it."""
    scan = log[index]
    points, segments, associations = scan.points_robot, [], []
    for face in np.intersect1d(met, worthy).tolist():
        seen = np.flatnonzero(met == face)
        for beams in _unbroken(scan, seen):
            number = len(segments)
            segments.append(ScanSegment(index, number, beams, points[beams], EndKind.EDGE, EndKind.EDGE))
            first, last = int(beams[0]), int(beams[-1])
            associations.append(
                Association(index, number, first, last, Verdict.MATCHED, face, 0.0, np.inf, relation=Relation.PART)
            )
    valid = int(np.count_nonzero(scan.valid))
    return KeyObservations(index, tuple(segments), tuple(associations), valid, scan.pose_robot_sensor[:2])


def _unbroken(scan: LaserScan, beams: Int[np.ndarray, "m"]) -> list[Int[np.ndarray, "_"]]:
    if len(beams) < 2:
        return [beams]
    jumps = breakpoints(scan.ranges[beams], scan.bearings[beams], scan.resolution, SegmentationConfig())
    return np.split(beams, np.flatnonzero(jumps) + 1)


def true_odometry(log: SimulatedLog, key_scans: Sequence[int], model: OdometryModel) -> tuple[PoseFactor, ...]:
    """Odometry between neighbouring key scans with the covariance of the noise that was really added to it."""
    assert log.records.odometry is not None
    records = log.scan_records
    return tuple(
        _odometry_factor(i, log.records.odometry[records[a] : records[b] + 1], model)
        for i, (a, b) in enumerate(pairwise(key_scans))
    )


def _odometry_factor(i: int, path: Float[np.ndarray, "r 3"], model: OdometryModel) -> PoseFactor:
    """Steps chained: the covariance of (x, y, θ) in the frame of the start, then turned into that of the end."""
    pose, covariance = np.zeros(3), STILL * np.eye(3)
    for step in se2.between(path[:-1], path[1:]):
        turn = se2.rotation(pose[2])
        dx, dy = turn @ step[:2]
        by_pose, by_step = np.eye(3), np.eye(3)
        by_pose[:2, 2], by_step[:2, :2] = (-dy, dx), turn
        noise = model.noise_covariance(float(np.hypot(step[0], step[1])))
        covariance = by_pose @ covariance @ by_pose.T + by_step @ noise @ by_step.T
        pose = se2.compose(pose, step)
    back = np.eye(3)
    back[:2, :2] = se2.rotation(-pose[2])
    information = np.linalg.inv(back @ covariance @ back.T)
    return PoseFactor(i, i + 1, pose, np.linalg.cholesky(information).T)


def localised(
    keys: Sequence[KeyObservations],
    splines: SplineMap,
    start: Float[np.ndarray, "3"],
    odometry: Sequence[PoseFactor],
    fitting: FittingConfig,
) -> Float[np.ndarray, "n 3"]:
    """Poses by dead reckoning from `start`, each moved onto the curves of the true map before the next step."""
    poses = [start]
    for key, edge in zip(keys[1:], odometry, strict=True):
        predicted = pose = se2.compose(poses[-1], edge.measured)
        belief = np.linalg.norm(edge.sqrt_information, axis=0) ** 2
        sights = collect_sights([key], splines)
        for gate in SEARCH_GATES:
            feet = find_feet(sights, splines, pose[None], gate)
            normals, arm = feet.normals[feet.counts], se2.rotate(pose, sights.points[feet.counts])
            rows = np.column_stack([normals, normals[:, 1] * arm[:, 0] - normals[:, 0] * arm[:, 1]])
            off = predicted - pose
            off[2] = se2.wrap(off[2])
            gradient = belief * off - rows.T @ feet.across[feet.counts] / fitting.range_noise**2
            pose = pose + np.linalg.solve(rows.T @ rows / fitting.range_noise**2 + np.diag(belief), gradient)
        poses.append(pose)
    return np.array(poses)


def _count(length: float) -> int:
    return max(int(np.ceil(length / SPACING)), 4 * THINNED) + 1


def _normals(points: Float[np.ndarray, "s 2"]) -> Float[np.ndarray, "s 2"]:
    along = np.gradient(points, axis=0)
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    return np.stack([-along[:, 1], along[:, 0]], -1)
