"""The command `run`: a whole log through the estimator without a display, and its results as files."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.backends.threads import in_one_thread
from bspline_slam.config import config_from_dict, read_config_file
from bspline_slam.errors import Cancelled
from bspline_slam.estimates import marginals
from bspline_slam.export.map_json import Covariances, map_to_json
from bspline_slam.export.map_svg import map_to_svg
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamConfig, SlamResult, StageProgress, check_names, run_slam
from splinescope.activity import STAGES
from splinescope.calibration_text import open_in_words, unfit_in_words
from splinescope.command_line.preparing import prepare
from splinescope.command_line.replay import check_log, journal_of, replayed
from splinescope.command_line.report import report
from splinescope.lost_scans import lost_in_words

Progress = Callable[[str, float], None]
Cancelling = Callable[[], bool]


@in_one_thread
def run_and_write(
    log_path: Path,
    out: Path,
    *,
    config_file: Path | None,
    back_end: str | None,
    model: str | None,
    edits: Path | None,
    progress: Progress,
    cancelled: Cancelling,
) -> dict[str, Any]:
    """Process the log, make the hand edits of a journal in it where one is given, and write trajectory, map, drawing
    and report into `out`; returns the report.

    Raises the library's errors; Cancelled leaves no files.
    """
    recorded = None
    if edits is None:
        config = resolved_config(config_file, back_end, model)
    else:
        recorded, config = journal_of(edits, config_file, back_end, model)
    seconds: dict[str, float] = {}
    with timed("reading", seconds):
        log = open_log(log_path, progress=lambda share: progress("Reading the log", share))

    if recorded is not None:
        check_log(log, recorded)
    prepare(progress, cancelled)
    result, told = run_slam(log, config, progress=in_words(progress), cancelled=cancelled), {}
    seconds |= result.seconds
    if recorded is not None:
        with timed("edits", seconds):
            result, told = replayed(log, config, result, recorded, in_words(progress), cancelled)
    progress("Computing covariances", 0.0)
    with timed("covariances", seconds):
        covariances = marginals(result.snapshot, splines=[spline.id for spline in result.snapshot.map]).splines
    if cancelled():
        raise Cancelled("cancelled before anything was written")
    return write_results(out, log, config, result, covariances, seconds, told)


def in_words(progress: Progress) -> StageProgress:
    """Progress of the pipeline, told in words."""

    def watch(stage: str, share: float, _: IterationRecord | None) -> None:
        if stage in STAGES:
            progress(STAGES[stage], share)

    return watch


def write_results(
    out: Path,
    log: ScanLog,
    config: SlamConfig,
    result: SlamResult,
    covariances: Covariances,
    seconds: dict[str, float],
    told: Mapping[str, Any] = {},
) -> dict[str, Any]:
    """The four files of a finished run; returns the report, `told` in it as well."""
    snapshot = result.snapshot
    out.mkdir(parents=True, exist_ok=True)
    Trajectory.from_scan_poses(log.records, snapshot.poses).to_tum(out / "trajectory.tum")
    map_to_json(snapshot.map, covariances, out / "map.json")
    map_to_svg(snapshot.map, out / "map.svg", trajectory=snapshot.poses, title=f"Map of {log.name}")
    summary = {**report(log, config, result, seconds), **told}
    (out / "report.json").write_text(json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return summary


@contextmanager
def timed(stage: str, seconds: dict[str, float]) -> Iterator[None]:
    """Note how long the block took."""
    started = perf_counter()
    yield
    seconds[stage] = perf_counter() - started


def resolved_config(file: Path | None, back_end: str | None, model: str | None) -> SlamConfig:
    """Defaults, changed by the file (a configuration, or the report of another run), changed by the options."""
    data = read_config_file(file) if file else {}
    data = data.get("configuration", data)
    if back_end is not None:
        data = data | {"back_end": back_end}
    if model is not None:
        data = data | {"model": model}
    config = config_from_dict(SlamConfig, data)
    check_names(config)  # a wrong name is refused now, not after the log was read
    return config


def summary_text(summary: dict[str, Any], out: Path) -> str:
    """What a person wants to know at the end of a run."""
    counts = summary["counts"]
    edits = edits_in_words(summary["edits"]) + "\n" if "edits" in summary else ""
    fit = f", χ²/dof {summary['chi2_per_dof']:.2f}" if summary.get("chi2_per_dof") else ""
    lost = lost_in_words(summary["lost_scans"], summary["log"]["odometry"]) + "\n" if summary["lost_scans"] else ""
    unfit = unfit_in_words(summary["odometry_unfit_scans"]) + "\n" if summary["odometry_unfit_scans"] else ""
    untold = open_in_words(summary["open_scans"]) + "\n" if summary["open_scans"] else ""
    return (
        f"{counts['scans']} scans, {counts['key_scans']} of them in the map: {counts['splines']} splines, "
        f"{counts['control_points']} control points, {counts['loop_closures']['accepted']} loop closures{fit}; "
        f"{summary['seconds_total']:.1f} s, {summary['peak_memory_mb']:.0f} MB\n"
        f"{lost}{unfit}{untold}{edits}"
        f"{out}/ trajectory.tum  map.json  map.svg  report.json"
    )


def edits_in_words(edits: Sequence[Mapping[str, str]]) -> str:
    """How many hand edits are in the result, and why some are not."""
    skipped = [f"{one['edit']}: {one['skipped']}" for one in edits if "skipped" in one]
    made = f"{len(edits) - len(skipped)} hand edits are in the map."
    return "\n".join([made, *(f"Left out: {reason}." for reason in skipped)])
