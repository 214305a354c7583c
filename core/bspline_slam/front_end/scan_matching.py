"""Scan matching: search first (correlative, branch and bound), then ICP, then point-to-line refinement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.front_end.icp import IcpConfig, align, icp_map
from bspline_slam.kernels import matching as kernels
from bspline_slam.kernels import surfaces
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import SegmentationConfig, break_limits


@dataclass(frozen=True, slots=True)
class MatchingConfig:
    """Search window, field and refinement (m, rad).

    `wide_…` is the window where no odometry tells where to look, `widest_…` that for a scan not found there. `pull` is
    the correlation that a guess at the rim of the window has to win against one at its centre. Beams beyond
    `largest_range` are used only where nearer ones leave a way open, as in a bare corridor or an empty hall.
    """

    cell: float = 0.05
    field_sigma: float = 0.06
    thinning: float = 0.06
    reach: float = 0.4
    turn: float = np.deg2rad(12.0)
    wide_reach: float = 0.6
    wide_turn: float = np.deg2rad(35.0)
    widest_reach: float = 2.0
    widest_turn: float = np.deg2rad(90.0)
    turn_step: float = np.deg2rad(0.5)
    pull: float = 0.1
    block: int = 4
    normal_reach: int = 4
    normal_flatness: float = 0.06
    sigma: float = 0.015
    gates: tuple[float, ...] = (0.3, 0.3, 0.2, 0.15, 0.1, 0.1, 0.1, 0.1)
    tracking_gates: tuple[float, ...] = (0.15, 0.15, 0.1, 0.1, 0.1)
    inlier_gate: float = 0.045
    largest_range: float = 40.0
    icp: IcpConfig = IcpConfig()


@dataclass(frozen=True, eq=False, slots=True)
class PointSet:
    """The beam ends of one scan that matching uses, robot frame; a normal is (0, 0) where the surface has none."""

    points: Float[np.ndarray, "m 2"]
    normals: Float[np.ndarray, "m 2"]


@dataclass(frozen=True, eq=False, slots=True)
class Target:
    """World points with normals that scans are matched to, sorted by square buckets; `start` has the first point of
    each, and one entry more."""

    points: Float[np.ndarray, "m 2"]
    normals: Float[np.ndarray, "m 2"]
    start: Int[np.ndarray, "buckets"]
    origin: Float[np.ndarray, "2"]
    shape: Int[np.ndarray, "2"]
    bucket: float

    @property
    def arguments(self) -> tuple[Any, Any, Any, Any, Any, float]:
        """What the kernels ask for, in their order."""
        return self.points, self.normals, self.start, self.origin, self.shape, self.bucket


@dataclass(frozen=True, eq=False, slots=True)
class Field:
    """Likelihood field of a target and its block maxima for branch and bound."""

    values: Float[np.ndarray, "rows columns"]
    bounds: Float[np.ndarray, "rows columns"]
    origin: Float[np.ndarray, "2"]
    cell: float
    block: int


@dataclass(frozen=True, eq=False, slots=True)
class Match:
    """Where a scan lies: world pose, correlation (0…1), share of inliers and their RMS (m).

    `information` (3, 3) is that of the beams alone, at the configured range noise.
    """

    pose: Float[np.ndarray, "3"]
    score: float
    inliers: float
    rms: float
    information: Float[np.ndarray, "3 3"]


BUCKET = 0.15
"""Side of the buckets (m): the widest gate of tracking, which then looks no farther than the neighbouring ones."""
MARGIN = 0.3
"""How far (m) a likelihood field reaches beyond its points."""
FARTHEST = 120.0
"""Beams that seem to come back from beyond this (m) tell of no wall that a scan could be matched to, and a field would
have to be as large."""
NO_PRIOR: Float[np.ndarray, "3 3"] = np.diag([1e-6, 1e-6, 1e-6])


def point_set(scan: LaserScan, config: MatchingConfig, segmentation: SegmentationConfig) -> PointSet:
    """The valid beam ends with normals from their neighbours on the same surface."""
    beams, limits = surface_arguments(scan, config, segmentation)
    return PointSet(*surfaces.points_with_normals(*beams, *limits))


def surface_arguments(
    scan: LaserScan, config: MatchingConfig, segmentation: SegmentationConfig
) -> tuple[
    tuple[Any, Any, float, float, float, float, float], tuple[float, float, float, float, float, int, float, float]
]:
    """What `kernels.surfaces.points_with_normals` asks for, of the beams and of what a surface is."""
    x, y, heading = scan.pose_robot_sensor.tolist()
    beams = (scan.ranges, scan.bearings, scan.range_min, min(scan.range_max, FARTHEST), x, y, heading)
    surface = config.normal_reach, config.normal_flatness, config.largest_range
    return beams, (*break_limits(scan.resolution, segmentation), *surface)


def gather(sets: Sequence[PointSet], poses: Float[np.ndarray, "n 3"], bucket: float = BUCKET) -> Target:
    """Several scans at their world poses as one target."""
    points, normals = np.concatenate([one.points for one in sets]), np.concatenate([one.normals for one in sets])
    return _target(points, normals, np.array([len(one.points) for one in sets]), poses, bucket)


def target(points: Float[np.ndarray, "m 2"], normals: Float[np.ndarray, "m 2"], bucket: float = BUCKET) -> Target:
    """World points with normals, sorted for nearest-neighbour look-up."""
    return _target(points, normals, np.array([len(points)]), np.zeros((1, 3)), bucket)


def _target(
    points: Float[np.ndarray, "m 2"],
    normals: Float[np.ndarray, "m 2"],
    sizes: Int[np.ndarray, "n"],
    poses: Float[np.ndarray, "n 3"],
    bucket: float,
) -> Target:
    if len(points) == 0:
        points, normals, sizes, poses = np.full((1, 2), 1e6), np.zeros((1, 2)), np.ones(1, dtype=int), np.zeros((1, 3))
    return Target(*kernels.gather(points, normals, sizes, poses, bucket), bucket)


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """A target made ready for a search: its likelihood field and its voxel map for ICP."""

    target: Target
    field: Field
    voxels: Any


def surroundings(target: Target, config: MatchingConfig, block: int | None = None) -> Surroundings:
    """Field and voxel map of a target; `block` is the side of the branch-and-bound blocks in cells."""
    return Surroundings(target, likelihood_field(target, config, block), icp_map(target.points, config.icp))


def likelihood_field(target: Target, config: MatchingConfig, block: int | None = None) -> Field:
    """The field that the search climbs."""
    block = block or config.block
    values, origin = kernels.likelihood_field(target.points, config.cell, config.field_sigma, MARGIN)
    return Field(values, kernels.block_maximum(values, block), origin, config.cell, block)


def search(
    field: Field, scan: PointSet, guess: Float[np.ndarray, "3"], config: MatchingConfig, reach: float, turn: float
) -> tuple[Float[np.ndarray, "3"], float]:
    """Correlative scan matching (Olson 2009) around `guess`: pose and correlation (0…1)."""
    points = _thinned(scan, config)
    if len(points) == 0:
        return guess, 0.0
    x, y, theta, score = kernels.search(
        field.values, field.bounds, field.block, field.origin, field.cell, points, guess, reach, turn,
        config.turn_step, config.pull,
    )  # fmt: skip
    return np.array([x, y, float(se2.wrap(theta))]), score


def correlation(field: Field, scan: PointSet, pose: Float[np.ndarray, "3"], config: MatchingConfig) -> float:
    """What `search` says of one pose."""
    points = _thinned(scan, config)
    return kernels.correlation(field.values, field.origin, field.cell, points, pose)


def _thinned(scan: PointSet, config: MatchingConfig) -> Float[np.ndarray, "m 2"]:
    """The points of a scan, those left out that are nearer than `thinning` to the one before."""
    return scan.points[kernels.thin(scan.points, config.thinning)]


def settle(
    place: Surroundings,
    scan: PointSet,
    found: Float[np.ndarray, "3"],
    score: float,
    config: MatchingConfig,
    prior: Float[np.ndarray, "3"] | None = None,
    prior_information: Float[np.ndarray, "3 3"] = NO_PRIOR,
) -> Match:
    """A pose found by search made exact: ICP on thinned points, then point-to-line, held by a Gaussian prior."""
    if len(scan.points) == 0:
        return Match(found, 0.0, 0.0, 0.0, np.zeros((3, 3)))
    thinned = _thinned(scan, config)
    guess = align(place.voxels, thinned, found, config.icp)
    return refine(place.target, scan, guess, config, score=score, prior=prior, prior_information=prior_information)


def find(
    sets: Sequence[PointSet],
    poses: Float[np.ndarray, "n 3"],
    scan: PointSet,
    guess: Float[np.ndarray, "3"],
    config: MatchingConfig,
    reach: float,
    turn: float,
    block: int | None = None,
) -> Match:
    """A scan searched for among others at their world poses and refined there without ICP, as one compiled call that
    does not hold the lock of the interpreter. Where it fits nearly as well farther along a wall, the match says nothing
    of the way along it."""
    points, normals = np.concatenate([one.points for one in sets]), np.concatenate([one.normals for one in sets])
    if len(points) == 0 or len(scan.points) == 0:
        return Match(guess, 0.0, 0.0, 0.0, np.zeros((3, 3)))
    pose, information, inliers, rms, score = kernels.find_and_refine(
        points, normals, np.array([len(one.points) for one in sets]), poses, BUCKET, config.cell, config.field_sigma,
        MARGIN, block or config.block, scan.points, scan.normals, config.thinning, guess, reach, turn,
        config.turn_step, config.pull, NO_PRIOR, config.sigma, np.array(config.gates), config.inlier_gate,
    )  # fmt: skip
    pose[2] = se2.wrap(pose[2])
    return Match(pose, score, inliers, rms, information)


def find_with_icp(
    sets: Sequence[PointSet],
    poses: Float[np.ndarray, "n 3"],
    scan: PointSet,
    guess: Float[np.ndarray, "3"],
    config: MatchingConfig,
    reach: float,
    turn: float,
    block: int | None = None,
) -> Match:
    """The same with ICP between search and refinement."""
    place = surroundings(gather(sets, poses), config, block)
    found, score = search(place.field, scan, guess, config, reach, turn)
    match = settle(place, scan, found, score, config)
    information = kernels.without_rivals(
        match.information,
        place.field.values,
        place.field.origin,
        config.cell,
        _thinned(scan, config),
        match.pose,
        reach,
    )
    return replace(match, information=information)


def refine(
    target: Target,
    scan: PointSet,
    guess: Float[np.ndarray, "3"],
    config: MatchingConfig,
    *,
    score: float = 1.0,
    prior: Float[np.ndarray, "3"] | None = None,
    prior_information: Float[np.ndarray, "3 3"] = NO_PRIOR,
    gates: tuple[float, ...] | None = None,
) -> Match:
    """Point-to-line Gauss–Newton from `guess` (Cauchy kernel), held by a Gaussian prior where the walls leave it
    free."""
    pose, information, inliers, rms = kernels.refine(
        scan.points, scan.normals, *target.arguments, guess, guess if prior is None else prior, prior_information,
        config.sigma, np.array(gates or config.gates), config.inlier_gate,
    )  # fmt: skip
    pose[2] = se2.wrap(pose[2])
    return Match(pose, score, inliers, rms, information)
