"""Fig. 8: SLAM between three splines of 13 control points with I-SLSJF, held against the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Estimate, Marginals
from bspline_slam.bspline import BSpline
from bspline_slam.export import figure as fig
from bspline_slam.fitting import FittingConfig, fit_parameters
from bspline_slam.lab import consistency
from bspline_slam.lab.reproduction.full_splines import FullSplines, Sight, estimated_curves, grown, problem
from bspline_slam.lab.reproduction.reproduced import NOT_GIVEN, Reproduced, Row, write_data
from bspline_slam.lab.simulation import SimulatedLog, simulate
from bspline_slam.lab.statistics import nees
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import open_world
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import SplineMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEED = 8
EXPERIMENT = consistency.Experiment("three_splines", "chord-length", "islsjf", "truth")
"""Which beam saw which spline is given, as the paper assumes (section 4)."""
LEAST_POINTS = 4
"""Of a sight that says where a spline lies."""
PLACES = 101
"""Of each curve, at which it is held against the truth."""


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """One simulated drive, what was estimated of it, and the truth: poses, and each full spline as control points."""

    world: World
    log: SimulatedLog
    keys: tuple[KeyObservations, ...]
    full: FullSplines
    estimate: Estimate
    marginals: Marginals
    true_poses: Float[np.ndarray, "n 3"]
    true_curves: dict[int, BSpline]

    @property
    def curves(self) -> dict[int, BSpline]:
        """The estimated splines by id."""
        return estimated_curves(self.full, self.estimate.control_points)

    @property
    def pose_nees(self) -> Float[np.ndarray, "n1"]:
        """Of each pose but the first, which is given; 3 is expected."""
        off = self.estimate.poses - self.true_poses
        off[:, 2] = se2.wrap(off[:, 2])
        return np.array([nees(off[k], self.marginals.poses[k])[0] for k in range(1, len(off))])

    @property
    def position_nees(self) -> Float[np.ndarray, "n1"]:
        """Of the position alone; up to 4 lies inside the 2σ ellipse."""
        off = (self.estimate.poses - self.true_poses)[:, :2]
        return np.array([nees(off[k], self.marginals.poses[k][:2, :2])[0] for k in range(1, len(off))])

    @property
    def control_point_nees(self) -> Float[np.ndarray, "s p"]:
        """Of each control point of each spline; up to 4 lies inside the 2σ ellipse."""
        return np.array(
            [
                [
                    nees(off, block)[0]
                    for off, block in zip(
                        curve.control_points - self.true_curves[spline].control_points,
                        control_point_blocks(self.marginals.splines[spline]),
                        strict=True,
                    )
                ]
                for spline, curve in self.curves.items()
            ]
        )

    @property
    def curve_distances(self) -> Float[np.ndarray, "s c"]:
        """Distance of each estimated curve from the true one, across it, in its own standard deviations."""
        return np.array([self._distances(spline, curve) for spline, curve in self.curves.items()])

    def _distances(self, spline: int, curve: BSpline) -> Float[np.ndarray, "c"]:
        t, true = np.linspace(0.0, 1.0, PLACES), self.true_curves[spline]
        normals, feet = curve.normals(t), true.foot_points(curve(t))
        rows = (curve.basis(t)[:, :, None] * normals[:, None, :]).reshape(PLACES, -1)
        across = ((curve(t) - true(feet)) * normals).sum(1)
        return across / np.sqrt(np.einsum("ci,ij,cj->c", rows, self.marginals.splines[spline], rows))


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
    start = consistency.problem_from_truth(world, log, config)
    scans = np.array([key.scan for key in start.keys])
    true_poses = log.true_poses[log.scan_records[scans]]
    full = grown(sights_of(start.keys), start.poses, config.fitting)
    solver = back_end(EXPERIMENT.back_end)
    estimate = solver.solve(problem(full, start.poses, scans, config.fitting, start.odometry))
    marginals = solver.covariances(estimate, poses=range(len(scans)), splines=list(full.first))
    return Run(
        world, log, start.keys, full, estimate, marginals, true_poses, true_curves(full, true_poses, start.splines)
    )


def sights_of(keys: Sequence[KeyObservations]) -> list[Sight]:
    """Every piece of a scan that saw a spline, in the order of the scans."""
    return [
        Sight(pose, association.spline, key.segments[association.segment].points, key.sensor)
        for pose, key in enumerate(keys)
        for association in key.associations
        if association.spline is not None and len(key.segments[association.segment].points) >= LEAST_POINTS
    ]


def true_curves(full: FullSplines, poses: Float[np.ndarray, "n 3"], splines: SplineMap) -> dict[int, BSpline]:
    """The stretch of truth that was seen of each full spline, as a spline of the same knots with parameters by length.

    It goes from the datum with the least parameter to that with the greatest, as they lie from the true poses.
    """
    curves = {}
    for spline, curve in full.curves.items():
        mine = [one for one in full.placed if one.sight.spline == spline]
        first = min(mine, key=lambda one: one.parameters[0])
        last = max(mine, key=lambda one: one.parameters[-1])
        truth = splines[spline].curve
        ends = np.array(
            [
                se2.transform(poses[first.sight.pose], first.sight.points[0]),
                se2.transform(poses[last.sight.pose], last.sight.points[-1]),
            ]
        )
        low, high = truth.foot_points(ends)
        t, points = truth.sample(0.01, (float(low), float(high)))
        exact = FittingConfig(stiffness=np.inf)
        curves[spline] = fit_parameters(points, (t - low) / (high - low), curve.knots, exact).curve
    return curves


def control_point_blocks(covariance: Float[np.ndarray, "d d"]) -> Float[np.ndarray, "n 2 2"]:
    """Covariance of each control point."""
    at = np.arange(len(covariance) // 2)
    return covariance.reshape(len(at), 2, len(at), 2)[at, :, at]


def reproduce(out: Path) -> Reproduced:
    """Draw world, scans and estimate; say how much of the truth lies inside 2σ."""
    run, stem = simulated_run(np.random.default_rng(SEED)), out / "figure_8"
    panels = [lambda axes: _truth(axes, run), lambda axes: _scans(axes, run), lambda axes: _estimate(axes, run)]
    files = fig.draw("Fig. 8 · SLAM between three splines, I-SLSJF", panels, stem, columns=3)
    data = {
        "seed": SEED,
        "true_poses": run.true_poses,
        "poses": run.estimate.poses,
        "pose_covariances": [run.marginals.poses[k] for k in range(len(run.estimate.poses))],
        "control_points": {spline: curve.control_points for spline, curve in run.curves.items()},
        "true_control_points": {spline: curve.control_points for spline, curve in run.true_curves.items()},
        "control_point_covariances": run.marginals.splines,
        "pose_nees": run.pose_nees,
        "position_nees": run.position_nees,
        "control_point_nees": run.control_point_nees,
        "curve_distances_sigma": run.curve_distances,
    }
    return Reproduced(tuple(_rows(run)), (*files, write_data(stem, data)))


def _rows(run: Run) -> Iterator[Row]:
    off = run.estimate.poses[1:, :2] - run.true_poses[1:, :2]
    position, points, curve = run.position_nees, run.control_point_nees, np.abs(run.curve_distances)
    yield Row("8c", "position error, RMS (m)", NOT_GIVEN, f"{np.sqrt(np.mean(np.sum(off**2, axis=1))):.3f}")
    for name, inside, expected in (
        ("true positions inside their 2σ ellipse", position < 4.0, "86.5%"),
        ("true control points inside their 2σ ellipse", points < 4.0, "86.5%"),
        ("true curve inside 2σ across it, places along it", curve < 2.0, "95.4%"),
    ):
        share = f"{np.count_nonzero(inside)} of {inside.size}"
        yield Row("8c", f"{name} ({expected} expected)", "“consistent”", share)
    yield Row("8c", "pose NEES per degree of freedom (1 expected)", NOT_GIVEN, f"{run.pose_nees.mean() / 3:.0f}")


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
    fig.to_scale(axes, f"(b) The {len(run.keys)} scans used, at true poses")
    for key, pose in zip(run.keys, run.true_poses, strict=True):
        for segment in key.segments:
            fig.dots(axes, se2.transform(pose, segment.points), fig.RED, markersize=1.0)


def _estimate(axes: Axes, run: Run) -> None:
    fig.to_scale(axes, "(c) Estimate with 2σ ellipses against the truth")
    _world(axes, run, "true splines")
    fig.line(axes, run.true_poses[:, :2], fig.GREY, "true poses", linewidth=1.0, marker="o", markersize=2.5)
    for k, (spline, curve) in enumerate(run.curves.items()):
        fig.line(axes, curve.sample(0.02)[1], fig.RED, "" if k else "estimated", linewidth=1.2)
        fig.dots(axes, curve.control_points, fig.RED, marker="+", markersize=4)
        fig.dots(
            axes, run.true_curves[spline].control_points, fig.BLUE, "" if k else "true control points", markersize=2
        )
        for point, block in zip(curve.control_points, control_point_blocks(run.marginals.splines[spline]), strict=True):
            fig.ellipse(axes, point, block, fig.ORANGE)
    for k, pose in enumerate(run.estimate.poses):
        fig.robot(axes, pose, fig.RED, size=0.12)
        fig.ellipse(axes, pose[:2], run.marginals.poses[k][:2, :2], fig.ORANGE)
    fig.legend(axes)
