"""One trial on a twin: simulate it, run the whole pipeline on the log, and hold everything it found against the truth.

Unlike `consistency`, nothing is told to the estimator: it has its own configuration, its own decisions, and a log with
biased odometry, people and blocked scans.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, Marginals, never
from bspline_slam.estimates import marginals
from bspline_slam.graph import Graph, PosePrior
from bspline_slam.lab.best_frame import BestFrame
from bspline_slam.lab.consistency_table import POSE_DOF, Figure
from bspline_slam.lab.evaluation import Figures, alignment
from bspline_slam.lab.simulation import SimulatedLog
from bspline_slam.lab.statistics import chi_square_band, nees
from bspline_slam.lab.truth import SPACING, TrueCurves
from bspline_slam.lab.twin import Twin, simulate_twin
from bspline_slam.progress import StageProgress, quiet
from bspline_slam.slam import run_slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import SplineMap

PLACES = 0.5
"""Distance (m) between the places on a curve where its error is measured."""
COUNTERPART = 0.3
"""A place on the map farther than this (m) from every true curve has none: somebody who walked by, or worse."""
AT_END = 0.2
"""Within this distance (m) of an end of a true curve others begin or leave off, and a smooth curve follows none of
them."""


@dataclass(frozen=True, eq=False, slots=True)
class CurveErrors:
    """Errors along the normal at places PLACES apart on the map, those with a true curve near them: their squares over
    their variances, the spline that each lies on, and whether a true curve ends near it. `without_truth` is the share
    of all places that have no true curve near them."""

    squares: Float[np.ndarray, "p"]
    splines: Int[np.ndarray, "p"]
    at_end: Bool[np.ndarray, "p"]
    without_truth: float


@dataclass(frozen=True, eq=False, slots=True)
class TwinErrors:
    """Errors of one trial. Positions (m) and headings (rad) after the rigid alignment of all positions that is best in
    the least-squares sense.

    `position` and `heading` are of all scans, `adjusted` and `pose_graph` the positions of key scans, after everything
    and from the pose graph alone. `pose_nees` has three degrees of freedom for each key scan. Errors of poses and of
    `curves` are seen from the frame that fits all key positions best, and so are their covariances.
    """

    scans: int
    key_scans: int
    control_points: int
    position: Figures
    heading: Figures
    adjusted: Figures
    pose_graph: Figures
    lost: int
    chi2_per_dof: float
    pose_nees: Float[np.ndarray, "n"]
    curves: CurveErrors
    processor_seconds: float

    @property
    def improvement(self) -> float:
        """Share by which the adjustment lowers the mean position error of the pose graph."""
        return 1.0 - self.adjusted.mean / self.pose_graph.mean


def run_trial(
    twin: Twin,
    rng: np.random.Generator,
    config: SlamConfig,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
) -> TwinErrors:
    """Simulate and estimate with all defaults, and compare. Raises SolverError where the estimator gives up, and
    Cancelled."""
    log = simulate_twin(twin, rng=rng)
    started = process_time()
    snapshot = run_slam(log, config, progress=progress, cancelled=cancelled).snapshot
    return twin_errors(twin, log, snapshot, config, process_time() - started)


def twin_errors(
    twin: Twin, log: SimulatedLog, snapshot: Snapshot, config: SlamConfig, processor_seconds: float
) -> TwinErrors:
    """A finished estimate of the log against its truth."""
    truth, keys, estimate = log.true_poses[log.scan_records], snapshot.key_scans, snapshot.estimate
    assert estimate is not None
    ids = [spline.id for spline in snapshot.map]
    found, frame = marginals(snapshot, poses=range(len(keys)), splines=ids), BestFrame.of(estimate)
    off = aligned_errors(snapshot.poses, truth)
    move = alignment(truth[keys, :2], estimate.poses[:, :2])
    return TwinErrors(
        scans=len(log),
        key_scans=len(keys),
        control_points=snapshot.map.control_point_count,
        position=Figures.of(np.linalg.norm(off[:, :2], axis=1)),
        heading=Figures.of(np.abs(off[:, 2])),
        adjusted=_positions(snapshot.poses[keys], truth[keys]),
        pose_graph=_positions(pose_graph_alone(snapshot, config), truth[keys]),
        lost=sum(step.lost for step in snapshot.steps),
        chi2_per_dof=estimate.chi2 / max(estimate.dof, 1),
        pose_nees=pose_errors(se2.compose(move, truth[keys]), estimate, found, frame),
        curves=curve_errors(twin, move, snapshot.map, estimate, found, frame),
        processor_seconds=processor_seconds,
    )


def aligned_errors(poses: Float[np.ndarray, "n 3"], truth: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """Differences (m, rad) after the rigid alignment of all positions."""
    off = se2.compose(alignment(poses[:, :2], truth[:, :2]), poses) - truth
    off[:, 2] = se2.wrap(off[:, 2])
    return off


def _positions(poses: Float[np.ndarray, "n 3"], truth: Float[np.ndarray, "n 3"]) -> Figures:
    return Figures.of(np.linalg.norm(aligned_errors(poses, truth)[:, :2], axis=1))


def pose_graph_alone(snapshot: Snapshot, config: SlamConfig) -> Float[np.ndarray, "n 3"]:
    """Key poses from odometry, scan matching and loop closures alone: what there would be without splines."""
    poses = snapshot.poses[snapshot.key_scans]
    graph = Graph(
        key_scans=snapshot.key_scans,
        poses=poses,
        spline_ids=np.zeros(0, dtype=np.int64),
        spline_first=np.zeros(1, dtype=np.int64),
        control_points=np.zeros((0, 2)),
        pose_factors=snapshot.pose_factors,
        pose_priors=(PosePrior(0, poses[0], np.eye(3) / config.adjustment.anchor),),
    )
    return back_end("pose_graph").solve(graph).poses


def pose_errors(
    true: Float[np.ndarray, "n 3"], estimate: Estimate, found: Marginals, frame: BestFrame
) -> Float[np.ndarray, "n"]:
    """NEES of the key poses against the truth in the frame of the estimate."""
    off = estimate.poses - true
    off[:, 2] = se2.wrap(off[:, 2])
    covariances = [frame.pose(estimate, k, found.poses[k]) for k in range(len(off))]
    return np.array([nees(error, covariance)[0] for error, covariance in zip(off, covariances, strict=True)])


def curve_errors(
    twin: Twin, move: Float[np.ndarray, "3"], splines: SplineMap, estimate: Estimate, found: Marginals, frame: BestFrame
) -> CurveErrors:
    """Those of the whole map; `move` puts the truth into the frame of the estimate."""
    samples = [se2.transform(move, curve.sample(SPACING)[1]) for curve in twin.curves]
    true, ends = TrueCurves.from_samples(samples), KDTree(np.concatenate([curve[[0, -1]] for curve in samples]))
    columns = 3 * len(estimate.poses) + 2 * estimate.graph.spline_first
    column = dict(zip(estimate.graph.spline_ids.tolist(), columns.tolist(), strict=False))
    squares, owners, at_end, places = [np.zeros(0)], [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=bool)], 0
    for spline in splines:
        low, high = spline.span
        count = max(int((high - low) / PLACES), 1)
        t = low + (np.arange(count) + 0.5) * (high - low) / count
        points, normals = spline.curve(t), spline.curve.normals(t)
        near = true.tree.query(points)[0] < COUNTERPART
        places += len(t)
        if spline.id in found.splines and near.any():
            rows = (spline.curve.basis(t)[:, :, None] * normals[:, None, :]).reshape(len(t), -1)
            variance = np.einsum("ti,ij,tj->t", rows, found.splines[spline.id], rows)
            variance = frame.across(points, normals, rows, column[spline.id], variance) + spline.left_out
            squares.append((true.distances(points, normals) ** 2 / variance)[near])
            owners.append(np.full(int(near.sum()), spline.id))
            at_end.append(ends.query(points[near])[0] < AT_END)
    counted = np.concatenate(squares)
    without = 1.0 - len(counted) / max(places, 1)
    return CurveErrors(counted, np.concatenate(owners), np.concatenate(at_end), without)


def pose_anees(trials: Sequence[TwinErrors]) -> Figure:
    """Mean NEES over its degrees of freedom. The poses of one trial share their errors: each trial is one sample of the
    band."""
    values = [float(trial.pose_nees.mean()) / POSE_DOF for trial in trials]
    return Figure(float(np.mean(values)), chi_square_band(POSE_DOF * len(trials)))


def curve_anees(trials: Sequence[TwinErrors], *, at_ends: bool = True) -> Figure:
    """Mean squared normalised error along the normal, with or without the places at ends of true curves. The places on
    one curve share its error: each curve is one sample of the band."""
    chosen = [at_ends | ~trial.curves.at_end for trial in trials]
    squares = np.concatenate([trial.curves.squares[kept] for trial, kept in zip(trials, chosen, strict=True)])
    seen = (len(np.unique(trial.curves.splines[kept])) for trial, kept in zip(trials, chosen, strict=True))
    return Figure(float(squares.mean()), chi_square_band(sum(seen)))
