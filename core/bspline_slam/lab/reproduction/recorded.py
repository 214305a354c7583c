"""Fig. 9: a small map of a recorded log by I-SLSJF, 30 clamped cubics of 13 control points seen from 23 scans."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Cancelling, Estimate, Marginals, never
from bspline_slam.bspline import BSpline
from bspline_slam.errors import LogError
from bspline_slam.export import figure as fig
from bspline_slam.fitting import FittingConfig
from bspline_slam.lab.reproduction.chosen_scans import Choice, choose
from bspline_slam.lab.reproduction.full_splines import (
    FullSplines,
    Sight,
    estimated_curves,
    grown,
    problem,
)
from bspline_slam.lab.reproduction.reproduced import NOT_GIVEN, Reproduced, Row, write_data
from bspline_slam.lab.reproduction.sight import CONTROL_POINTS
from bspline_slam.lab.statistics import nees
from bspline_slam.progress import StageProgress, quiet
from bspline_slam.scan import ScanLog
from bspline_slam.slam import run_slam
from bspline_slam.snapshot import Snapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCANS, SPLINES = 23, 30
"""As many as on the paper's map."""
FITTING = FittingConfig()


@dataclass(frozen=True, eq=False, slots=True)
class SmallMap:
    """What was chosen, where the whole log has these poses, and the map made of them alone."""

    choice: Choice
    reference: Float[np.ndarray, "n 3"]
    full: FullSplines
    estimate: Estimate
    marginals: Marginals

    @property
    def curves(self) -> dict[int, BSpline]:
        """The estimated splines by id."""
        return estimated_curves(self.full, self.estimate.control_points)

    @property
    def off(self) -> Float[np.ndarray, "n 3"]:
        """The poses less those of the whole log (m, m, rad)."""
        off = self.estimate.poses - self.reference
        off[:, 2] = se2.wrap(off[:, 2])
        return off


def small_map(snapshot: Snapshot, log: ScanLog, cancelled: Cancelling = never) -> SmallMap:
    """Choose scans and splines of a finished run, and estimate them anew, each scan a local map.

    Relations are decided at the poses of the whole log, which stand for the paper's scan matching; nothing else of
    them is used. Scans are joined in the order in which they were chosen. Raises LogError where too little wall was
    seen twice.
    """
    choice = choose(snapshot, SCANS, SPLINES)
    if len(choice.keys) < 2:
        raise LogError(log.path, "no two of its scans share enough wall to make a map of splines from")
    keys = list(choice.keys)
    scans = snapshot.key_scans[keys]
    reference = snapshot.poses[scans]
    sights = [
        Sight(pose, seen.spline, seen.points, snapshot.observations[key].sensor)
        for pose, (key, all_seen) in enumerate(zip(keys, choice.sights, strict=True))
        for seen in all_seen
    ]
    full = grown(sights, reference, FITTING)
    solver = back_end("islsjf")
    estimate = solver.solve(problem(full, reference, scans, FITTING), cancelled=cancelled)
    marginals = solver.covariances(estimate, poses=range(len(keys)), splines=list(full.first))
    return SmallMap(choice, reference, full, estimate, marginals)


def reproduce(out: Path, log: ScanLog, progress: StageProgress = quiet, cancelled: Cancelling = never) -> Reproduced:
    """Run the whole log, choose, estimate, draw; the whole log is also what the estimate is held against."""
    found = small_map(run_slam(log, progress=progress, cancelled=cancelled).snapshot, log, cancelled)
    stem, count = out / "figure_9", len(found.choice.keys)
    inside = [nees(off[:2], found.marginals.poses[k][:2, :2])[0] < 4.0 for k, off in enumerate(found.off) if k > 0]
    files = fig.draw(
        f"Fig. 9 · {count} scans of {log.name}, I-SLSJF",
        [lambda axes: _control_points(axes, found), lambda axes: _splines(axes, found)],
        stem,
        height=5.2,
    )
    curves = found.curves
    data = {
        "log": log.name,
        "scans": found.estimate.graph.key_scans,
        "poses": found.estimate.poses,
        "pose_covariances": [found.marginals.poses[k] for k in range(count)],
        "poses_of_whole_log": found.reference,
        "knots": next(iter(curves.values())).knots,
        "control_points": {spline: curve.control_points for spline, curve in curves.items()},
        "control_point_covariances": found.marginals.splines,
        "chi2": found.estimate.chi2,
        "dof": found.estimate.dof,
    }
    position, heading = np.hypot(*found.off[1:, :2].T), np.degrees(np.abs(found.off[1:, 2]))
    rows = (
        Row("9", "scans", str(SCANS), str(count)),
        Row("9", "cubic splines × control points of each", f"{SPLINES} × 13", f"{len(curves)} × {CONTROL_POINTS}"),
        Row("9", "χ² per degree of freedom", NOT_GIVEN, f"{found.estimate.chi2 / found.estimate.dof:.1f}"),
        Row("9", "positions against those of the whole log, RMS (m)", NOT_GIVEN, f"{_rms(position):.2f}"),
        Row("9", "headings against those of the whole log, RMS (°)", NOT_GIVEN, f"{_rms(heading):.2f}"),
        Row("9", "positions of the whole log inside 2σ ellipses", NOT_GIVEN, f"{sum(inside)} of {len(inside)}"),
    )
    return Reproduced(rows, (*files, write_data(stem, data)))


def _rms(values: Float[np.ndarray, "n"]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _control_points(axes: Axes, found: SmallMap) -> None:
    fig.to_scale(axes, "(a) Control points and poses with 2σ ellipses")
    for k, (spline, curve) in enumerate(found.curves.items()):
        blocks = found.marginals.splines[spline].reshape(CONTROL_POINTS, 2, CONTROL_POINTS, 2)
        for i, point in enumerate(curve.control_points):
            fig.ellipse(axes, point, blocks[i, :, i], fig.BLUE)
        fig.dots(axes, curve.control_points, fig.BLUE, "" if k else "control points", marker="+", markersize=4)
    for k, pose in enumerate(found.estimate.poses):
        fig.ellipse(axes, pose[:2], found.marginals.poses[k][:2, :2], fig.ORANGE)
        fig.robot(axes, pose, fig.RED, "" if k else "poses", size=0.3)
    fig.legend(axes)


def _splines(axes: Axes, found: SmallMap) -> None:
    fig.to_scale(axes, "(b) Splines, and the points they were made of")
    for sight in (one.sight for one in found.full.placed):
        points = se2.transform(found.estimate.poses[sight.pose], sight.points)
        fig.dots(axes, points, fig.GREY, markersize=1.0)
    for k, curve in enumerate(found.curves.values()):
        fig.line(axes, curve.sample(0.02)[1], fig.BLUE, "" if k else "splines", linewidth=1.2)
    for k, (pose, whole) in enumerate(zip(found.estimate.poses, found.reference, strict=True)):
        fig.robot(axes, whole, fig.GREEN, "" if k else "poses of the whole log", size=0.3)
        fig.robot(axes, pose, fig.RED, "" if k else "poses", size=0.3)
    fig.legend(axes)
