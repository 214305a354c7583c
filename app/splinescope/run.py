"""The command `run`: a whole log through the estimator without a display, and its results as files."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bspline_slam.config import config_from_dict, read_config_file
from bspline_slam.export.map_json import map_to_json
from bspline_slam.export.map_svg import map_to_svg
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.logs import open_log
from bspline_slam.slam import SlamConfig, marginals, run_slam
from splinescope.report import report

Progress = Callable[[str, float], None]
Cancelling = Callable[[], bool]


def run_and_write(
    log_path: Path,
    out: Path,
    *,
    config_file: Path | None,
    back_end: str | None,
    model: str | None,
    progress: Progress,
    cancelled: Cancelling,
) -> dict[str, Any]:
    """Process the log and write trajectory, map, drawing and report into `out`; returns the report.

    Raises the library's errors; Cancelled leaves no files.
    """
    config = resolved_config(config_file, back_end, model)
    log = open_log(log_path, progress=lambda share: progress("Reading the log", share))
    result = run_slam(log, config, progress=lambda stage, share, _: progress(stage, share), cancelled=cancelled)
    snapshot = result.snapshot
    ids = [spline.id for spline in snapshot.map]
    covariances = marginals(snapshot, config.back_end, (), ids).splines
    out.mkdir(parents=True, exist_ok=True)
    Trajectory.from_scan_poses(log.records, snapshot.poses).to_tum(out / "trajectory.tum")
    map_to_json(snapshot.map, covariances, out / "map.json")
    map_to_svg(snapshot.map, out / "map.svg", trajectory=snapshot.poses, title=f"Map of {log.name}")
    summary = report(log, config, result)
    (out / "report.json").write_text(json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return summary


def resolved_config(file: Path | None, back_end: str | None, model: str | None) -> SlamConfig:
    """Defaults, changed by the file (a configuration, or the report of another run), changed by the options."""
    data = read_config_file(file) if file else {}
    data = data.get("configuration", data)
    chosen = {"back_end": back_end, "model": model}
    return config_from_dict(SlamConfig, data | {key: value for key, value in chosen.items() if value is not None})


def summary_text(summary: dict[str, Any], out: Path) -> str:
    """What a person wants to know at the end of a run."""
    counts = summary["counts"]
    fit = f", χ²/dof {summary['chi2_per_dof']:.2f}" if summary.get("chi2_per_dof") else ""
    return (
        f"{counts['scans']} scans, {counts['key_scans']} of them in the map: {counts['splines']} splines, "
        f"{counts['control_points']} control points, {counts['loop_closures']['accepted']} loop closures{fit}; "
        f"{summary['seconds_total']:.1f} s, {summary['peak_memory_mb']:.0f} MB\n"
        f"{out}/ trajectory.tum  map.json  map.svg  report.json"
    )
