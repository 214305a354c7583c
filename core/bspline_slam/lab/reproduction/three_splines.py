"""Fig. 8: SLAM between three splines with I-SLSJF and the chord-length observation, held against the truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Estimate, Marginals
from bspline_slam.export import figure as fig
from bspline_slam.lab import consistency
from bspline_slam.lab.reproduction.reproduced import NOT_GIVEN, Reproduced, Row, write_data
from bspline_slam.lab.simulation import SimulatedLog, simulate
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import open_world
from bspline_slam.spline_map import SplineMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEED = 8
EXPERIMENT = consistency.Experiment("three_splines", "chord-length", "islsjf", "truth")
"""Which beam saw which spline is given, as the paper assumes (section 4)."""


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """One simulated drive, what was estimated of it, and how far off that is."""

    world: World
    log: SimulatedLog
    problem: consistency.Problem
    splines: SplineMap
    estimate: Estimate
    marginals: Marginals
    errors: consistency.RunErrors

    @property
    def true_poses(self) -> Float[np.ndarray, "n 3"]:
        return self.log.true_poses[self.log.scan_records[[key.scan for key in self.problem.keys]]]


def simulated_run(rng: np.random.Generator) -> Run:
    """Drive through the world of three splines once and estimate poses and control points."""
    world, config = open_world(EXPERIMENT.world), consistency.told_the_truth(EXPERIMENT)
    log = simulate(
        world,
        rng=rng,
        noise=consistency.RANGE_NOISE,
        bearing_noise=consistency.BEARING_NOISE,
        odometry=consistency.ODOMETRY,
    )
    problem = consistency.problem_from_truth(world, log, config)
    splines, estimate = consistency.settled(problem, config)
    ids = [int(spline) for spline in estimate.graph.spline_ids]
    marginals = back_end(config.back_end).covariances(estimate, poses=range(len(estimate.poses)), splines=ids)
    errors = consistency.run_errors(world, log, problem, splines, estimate, config)
    return Run(world, log, problem, splines, estimate, marginals, errors)


def reproduce(out: Path) -> Reproduced:
    """Draw world, scans and estimate; say how many true positions lie inside their 2σ ellipses."""
    run = simulated_run(np.random.default_rng(SEED))
    stem, errors = out / "figure_8", run.errors
    panels = [lambda axes: _truth(axes, run), lambda axes: _scans(axes, run), lambda axes: _estimate(axes, run)]
    files = fig.draw("Fig. 8 · SLAM between three splines, I-SLSJF", panels, stem, columns=3)
    data = {
        "seed": SEED,
        "true_poses": run.true_poses,
        "poses": run.estimate.poses,
        "pose_covariances": [run.marginals.poses[k] for k in range(len(run.estimate.poses))],
        "control_points": {spline.id: spline.curve.control_points for spline in run.splines},
        "control_point_covariances": run.marginals.splines,
        "pose_nees": errors.pose_nees,
        "inside_2_sigma": errors.inside,
        "curve_nees": errors.curve_nees,
        "curve_dof": errors.curve_dof,
    }
    share = f"{int(errors.inside.sum())} of {len(errors.inside)}"
    rows = (
        Row("8c", "position error, RMS (m)", NOT_GIVEN, f"{errors.position_error:.3f}"),
        Row("8c", "true positions inside their 2σ ellipse", "“consistent”", share),
        Row("8c", "pose NEES per degree of freedom (1 expected)", NOT_GIVEN, f"{errors.pose_nees.mean() / 3:.0f}"),
        Row("8c", "curve NEES per degree of freedom", NOT_GIVEN, f"{errors.curve_nees / errors.curve_dof:.0f}"),
    )
    return Reproduced(rows, (*files, write_data(stem, data)))


def _world(axes: Axes, run: Run, label: str) -> None:
    for k, spline in enumerate(run.world.splines):
        fig.line(axes, spline.sample(0.02)[1], fig.BLUE, label if k == 0 else "", linewidth=1.8)


def _truth(axes: Axes, run: Run) -> None:
    fig.to_scale(axes, "(a) Splines and trajectory")
    _world(axes, run, "true splines")
    fig.line(axes, run.log.true_poses[:, :2], fig.GREY, "true trajectory", linewidth=1.0)
    for pose in run.true_poses:
        fig.robot(axes, pose, fig.INK, size=0.12)
    fig.legend(axes)


def _scans(axes: Axes, run: Run) -> None:
    fig.to_scale(axes, f"(b) The {len(run.problem.keys)} scans used, at true poses")
    for key, pose in zip(run.problem.keys, run.true_poses, strict=True):
        for segment in key.segments:
            fig.dots(axes, se2.transform(pose, segment.points), fig.RED, markersize=1.0)


def _estimate(axes: Axes, run: Run) -> None:
    fig.to_scale(axes, "(c) Estimate with 2σ ellipses against the truth")
    _world(axes, run, "true splines")
    fig.line(axes, run.true_poses[:, :2], fig.GREY, "true poses", linewidth=1.0, marker="o", markersize=2.5)
    for k, spline in enumerate(run.splines):
        fig.line(axes, spline.sample(0.02)[1], fig.RED, "" if k else "estimated", linewidth=1.2)
        fig.dots(axes, spline.curve.control_points, fig.RED, marker="+", markersize=4)
    for k, pose in enumerate(run.estimate.poses):
        fig.robot(axes, pose, fig.RED, size=0.12)
        fig.ellipse(axes, pose[:2], run.marginals.poses[k][:2, :2], fig.ORANGE)
    fig.legend(axes)
