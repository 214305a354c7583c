"""Do covariances tell the truth? One simulated run: its errors, held against what the estimator believes of them.

The estimator is told what the simulation does: the noise of the laser with the rounding of its ranges, and that of
odometry, which has no bias here. Beams are not weighted down, for there are no outliers. So whatever leaves its band
is the fault of the observation model, of the back end, or of wrong associations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam import se2
from bspline_slam.adjustment.adjust import adjust_splines, with_estimate
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.adjustment.spline_graph import build_graph
from bspline_slam.backends import FILTERS, Stopping, back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, Marginals, never
from bspline_slam.backends.statistics import information_of
from bspline_slam.errors import SolverError
from bspline_slam.fitting import FittingConfig
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.graph import PoseFactor
from bspline_slam.lab.simulation import QUANTUM, OdometryModel, SimulatedLog, simulate
from bspline_slam.lab.statistics import nees
from bspline_slam.lab.truth import TrueCurves, localised, true_map, true_observations, true_odometry
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import open_world
from bspline_slam.observation import MODELS
from bspline_slam.sights import KeyObservations, collect_sights, find_feet
from bspline_slam.slam import run_slam
from bspline_slam.slam_config import SlamConfig, model_of
from bspline_slam.spline_map import MapSpline, SplineMap

ASSOCIATIONS = ("truth", "automatic")
"""Who says which beam saw which curve: the simulation, or the pipeline."""
RANGE_NOISE = 0.012
BEARING_NOISE = 0.001
ODOMETRY = OdometryModel(scale=0.0, turn_scale=0.0, turn_bias=0.0)
ROUNDS = (*(Stopping(decrease=1e-4, move=1e-3, iterations=4),) * 4, Stopping())
"""When to stop solving before foot points are found anew, round by round."""
POSITIONS = 0.5
"""Distance (m) between the places on a curve where its error is measured."""
REACH, LEAST_BEAMS = 0.2, 5
"""A place counts when so many beams ended within this distance (m) of it along the curve."""
SLIDE = {"truth": 0.05, "automatic": AdjustmentConfig().slide}
"""How firmly (m) curves are held along themselves. Those given by truth keep all their knots, and many control points
begin farther along the curve from where they belong than the few that the pipeline leaves."""
LEAST_DEVIATION = 1e-4
"""Combinations of places that claim to be known better than this (m), the error of the model, are left out."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """What is put to the test: a world (by name or file), an observation model, a back end, and the associations."""

    world: str
    model: str = MODELS[0]
    back_end: str = "direct"
    association: str = ASSOCIATIONS[0]


@dataclass(frozen=True, eq=False, slots=True)
class RunErrors:
    """The normalised errors of one run; one entry per key scan but the first, which is given.

    `pose_nees` has three degrees of freedom each, `inside` says whether the position lies in its 2σ ellipse, `scans`
    when it was. `innovation` is what the last key scan adds to the least χ², which is its NIS in a linear problem; NaN
    where the problem cannot be solved without it, and for filters. `position_error` is the root mean square (m).
    """

    scans: tuple[int, ...]
    pose_nees: Float[np.ndarray, "n"]
    inside: Bool[np.ndarray, "n"]
    curve_nees: float
    curve_dof: float
    chi2: float
    dof: float
    innovation: float
    innovation_dof: float
    position_error: float


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """Everything that an estimator starts from, in the frame of the true world."""

    keys: tuple[KeyObservations, ...]
    poses: Float[np.ndarray, "n 3"]
    splines: SplineMap
    odometry: tuple[PoseFactor, ...]


def run_once(experiment: Experiment, rng: np.random.Generator, cancelled: Cancelling = never) -> RunErrors:
    """Simulate, estimate, compare.

    Raises ConfigError for an unknown world, SolverError where a back end gives up, and Cancelled.
    """
    world = open_world(experiment.world)
    log = simulate(world, rng=rng, noise=RANGE_NOISE, bearing_noise=BEARING_NOISE, odometry=ODOMETRY)
    config = told_the_truth(experiment)
    if experiment.association == ASSOCIATIONS[0]:
        problem = problem_from_truth(world, log, config)
        splines, estimate = settled(problem, config, cancelled)
    else:
        problem = problem_from_pipeline(log, config, cancelled)
        splines, estimate = adjust_splines(
            problem.keys, problem.poses, problem.splines, problem.odometry, config.adjustment, model_of(config),
            experiment.back_end, lambda fraction, record: None, cancelled,
        )  # fmt: skip
    return run_errors(world, log, problem, splines, estimate, config)


def told_the_truth(experiment: Experiment) -> SlamConfig:
    """The pipeline's configuration with the noise of the simulation, rounded ranges included, and no robust
    weights."""
    range_noise = float(np.hypot(RANGE_NOISE, QUANTUM / np.sqrt(12)))
    return SlamConfig(
        back_end=experiment.back_end,
        model=experiment.model,
        fitting=FittingConfig(range_noise=range_noise, bearing_noise=BEARING_NOISE),
        adjustment=AdjustmentConfig(outlier=np.inf, slide=SLIDE[experiment.association], estimate_noise=False),
    )


def problem_from_truth(world: World, log: SimulatedLog, config: SlamConfig) -> Problem:
    """Key scans by the pipeline's distances, each beam given to the curve that it met, poses found from odometry."""
    scans = key_scans(log, config.tracking)
    keys = true_observations(world, log, scans)
    faces = sorted({a.spline for key in keys for a in key.associations if a.spline is not None})
    splines = true_map(world, model_of(config), faces)
    odometry = true_odometry(log, scans, ODOMETRY)
    start = log.true_poses[log.scan_records[scans[0]]]
    return Problem(keys, localised(keys, splines, start, odometry, config.fitting), splines, odometry)


def problem_from_pipeline(log: SimulatedLog, config: SlamConfig, cancelled: Cancelling = never) -> Problem:
    """Key scans, associations, poses and splines as the pipeline finds them, moved so that the first pose is true."""
    snapshot = run_slam(log, replace(config, back_end="direct"), cancelled=cancelled).snapshot
    poses = snapshot.poses[snapshot.key_scans]
    scans = [int(scan) for scan in snapshot.key_scans]
    start = log.true_poses[log.scan_records[scans[0]]]
    move = se2.compose(start, se2.inverse(poses[0]))
    splines = SplineMap(tuple(spline.moved(move) for spline in snapshot.map))
    return Problem(snapshot.observations, se2.compose(move, poses), splines, true_odometry(log, scans, ODOMETRY))


def key_scans(log: SimulatedLog, config: TrackingConfig) -> list[int]:
    """Scans that lie far enough from the one before, by odometry."""
    assert log.odometry is not None
    chosen = [0]
    for index, pose in enumerate(log.odometry):
        step = se2.between(log.odometry[chosen[-1]], pose)
        if np.hypot(step[0], step[1]) > config.distance or abs(step[2]) > config.turn:
            chosen.append(index)
    return chosen


def settled(problem: Problem, config: SlamConfig, cancelled: Cancelling = never) -> tuple[SplineMap, Estimate]:
    """Solve, find new foot points, solve again, without ever cutting a spline: the map and the last estimate."""
    poses, splines, estimate = problem.poses, problem.splines, None
    model = model_of(config)
    for stopping in ROUNDS:
        sights = collect_sights(problem.keys, splines)
        graph = build_graph(
            problem.keys, poses, splines, problem.odometry, sights, config.adjustment, model,
            config.adjustment.gates[-1],
        )  # fmt: skip
        estimate = back_end(config.back_end, stopping).solve(graph, cancelled=cancelled)
        poses, splines = estimate.poses, with_estimate(splines, estimate)
    assert estimate is not None
    return splines, estimate


def run_errors(
    world: World, log: SimulatedLog, problem: Problem, splines: SplineMap, estimate: Estimate, config: SlamConfig
) -> RunErrors:
    """The estimate against the truth, each error measured by the covariance that the back end gives."""
    scans = tuple(key.scan for key in problem.keys[1:])
    later = range(1, len(problem.keys))
    solver = back_end(config.back_end)
    marginals = solver.covariances(estimate, poses=later, splines=[int(s) for s in estimate.graph.spline_ids])
    off = estimate.poses - log.true_poses[log.scan_records[[key.scan for key in problem.keys]]]
    off[:, 2] = se2.wrap(off[:, 2])
    sights = collect_sights(problem.keys, splines)
    feet = find_feet(sights, splines, estimate.poses, config.adjustment.gates[-1])
    seen = {spline.id: feet.t[(sights.spline == k) & feet.counts] for k, spline in enumerate(splines)}
    curve_nees, curve_dof = curve_errors(TrueCurves.from_world(world), splines, seen, estimate, marginals)
    chi2_before, dof_before = before_last(problem, splines, estimate, config)
    return RunErrors(
        scans=scans,
        pose_nees=np.array([nees(off[k], marginals.poses[k])[0] for k in later]),
        inside=np.array([nees(off[k, :2], marginals.poses[k][:2, :2])[0] < 4.0 for k in later]),
        curve_nees=curve_nees,
        curve_dof=curve_dof,
        chi2=estimate.chi2,
        dof=estimate.dof,
        innovation=estimate.chi2 - chi2_before,
        innovation_dof=estimate.dof - dof_before,
        position_error=float(np.sqrt(np.mean(np.sum(off[1:, :2] ** 2, axis=1)))),
    )


def curve_errors(
    curves: TrueCurves,
    splines: SplineMap,
    seen: Mapping[int, Float[np.ndarray, "_"]],
    estimate: Estimate,
    marginals: Marginals,
) -> tuple[float, float]:
    """NEES of the errors across all curves at fixed distances along them, and its degrees of freedom; `seen` are the
    parameters at which beams saw each spline.

    At the parameters t_k of one spline the errors e_k across the curve have the covariance C = G P Gᵀ, the rows of G
    being β_i(t_k) n_kᵀ. Its rank counts, less what no beam but only gauge and shape prior (information Q) determine:
    those hold the control points where they started, so E[e eᵀ] = G (P − P Q P) Gᵀ and tr(C⁻¹ G P Q P Gᵀ) is missing.
    """
    held = dict(zip(estimate.graph.spline_ids.tolist(), information_of(estimate)[1], strict=True))
    total, dof = 0.0, 0.0
    for spline in splines:
        t = _places(spline, seen[spline.id])
        if len(t) == 0 or spline.id not in marginals.splines:
            continue
        normals = spline.curve.normals(t)
        across = curves.distances(spline.curve(t), normals)
        rows = (spline.curve.basis(t)[:, :, None] * normals[:, None, :]).reshape(len(t), -1)
        gain = rows @ marginals.splines[spline.id]
        covariance = gain @ rows.T + spline.left_out * np.eye(len(t))
        value, free = nees(across, covariance, LEAST_DEVIATION**2, gain @ held[spline.id] @ gain.T)
        total, dof = total + value, dof + free
    return total, dof


def _places(spline: MapSpline, seen: Float[np.ndarray, "m"]) -> Float[np.ndarray, "k"]:
    """Parameters POSITIONS apart at which enough beams saw the curve."""
    low, high = spline.span
    places = np.arange(np.ceil(low / POSITIONS - 0.5) + 0.5, high / POSITIONS) * POSITIONS
    beams = np.abs(seen - places[:, None]) < REACH
    return places[beams.sum(axis=1) >= LEAST_BEAMS]


def before_last(problem: Problem, splines: SplineMap, estimate: Estimate, config: SlamConfig) -> tuple[float, float]:
    """χ² and degrees of freedom without the last key scan, all other beams on the same feet; NaN where the rest cannot
    be solved alone, and for filters."""
    if config.back_end in FILTERS:
        return float("nan"), float("nan")
    start = estimate.graph
    splines = with_estimate(splines, replace(estimate, control_points=start.control_points))
    keys = problem.keys[:-1]
    edges = [edge for edge in problem.odometry if edge.j < len(keys)]
    sights = collect_sights(keys, splines)
    graph = build_graph(
        keys, start.poses[:-1], splines, edges, sights, config.adjustment, model_of(config), config.adjustment.gates[-1]
    )
    try:
        before = back_end(config.back_end).solve(graph)
    except SolverError:
        return float("nan"), float("nan")
    return before.chi2, before.dof
