"""The command `evaluate`: everything that can be said of a finished run, as plain data and as text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bspline_slam.errors import ConfigError
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.lab.corner_gaps import CornerGaps
from bspline_slam.lab.crispness import crispness
from bspline_slam.lab.double_walls import double_walls
from bspline_slam.lab.evaluation import TrajectoryErrors
from bspline_slam.lab.finished_run import MAP, TRAJECTORY, FinishedRun
from bspline_slam.lab.held_out import held_out
from bspline_slam.lab.map_size import MapSize
from bspline_slam.lab.relations import RelationErrors, Relations
from bspline_slam.lab.wall_beams import WallBeams
from splinescope.command_line import evaluation_text as text


def evaluate_results(
    results: Path, *, relations: Path | None, reference: Path | None, log: Path | None
) -> dict[str, Any]:
    """The figures of a folder of results, or of a trajectory alone; raises the library's errors."""
    if not results.is_dir():
        if log is not None:
            raise ConfigError(f"--log goes with a folder of results that holds a map, and {results} is none")
        if relations is None and reference is None:
            raise ConfigError("evaluate needs a folder of results, or --relations FILE or --reference FILE, or both")
    figures: dict[str, Any] = {}
    trajectory = Trajectory.from_tum(results / TRAJECTORY if results.is_dir() else results)
    if relations:
        errors = RelationErrors.from_trajectory(trajectory, Relations.from_file(relations))
        figures["relations"] = text.relation_figures(errors)
    if reference:
        errors = TrajectoryErrors.from_trajectories(trajectory, Trajectory.from_tum(reference))
        figures["reference"] = text.trajectory_figures(errors)
    if log is not None or (results / MAP).is_file():
        figures |= map_figures(FinishedRun.from_folder(results), log)
    return figures


def map_figures(run: FinishedRun, log_path: Path | None) -> dict[str, Any]:
    """Size and cost of the map; with the log also how well it fits that."""
    beams, fit = None, {}
    if log_path is not None:
        log = run.open_log(log_path)
        config = run.config("segmentation", "tracking")
        beams = WallBeams.from_log(log, run.scan_poses(log), config.tracking, config.segmentation, run.laser)
        fit = {
            "crispness": text.crispness_figures(crispness(beams, run.splines)),
            "held_out": text.crispness_figures(held_out(beams, run.splines, config)),
        }
    size = text.size_figures(MapSize.of(run.splines, beams), double_walls(run.splines), CornerGaps.of(run.splines))
    return fit | {"map": size, "run": text.cost_figures(run.report)}


def evaluation_text(figures: dict[str, Any]) -> str:
    """The figures as lines for a terminal."""
    parts = {
        "relations": text.relation_text,
        "reference": text.trajectory_text,
        "crispness": text.crispness_text,
        "held_out": text.held_out_text,
        "map": text.size_text,
        "run": text.cost_text,
    }
    return "\n".join(part for name, write in parts.items() if name in figures and (part := write(figures[name])))
