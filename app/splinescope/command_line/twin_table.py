"""Trials on a twin as a table and as plain data."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from bspline_slam.lab.consistency_table import Figure
from bspline_slam.lab.twin_trial import TwinErrors, curve_anees, pose_anees

HEADERS = (
    "seed", "scans", "mean mm", "largest mm", "mean °", "graph mm", "splines mm", "better", "lost", "χ²/dof",
    "pose ANEES", "curve ANEES", "off ends", "no truth", "CPU s",
)  # fmt: skip
LEGEND = """\
mean, largest: position errors of all scans; graph, splines: mean position error of key scans by the pose graph alone
and after the adjustment; better: by how much. All after the rigid alignment that is best for positions (Umeyama).
ANEES: 1 is honest, with its 95 % band over all seeds; poses and curves (across them) in the frame of that alignment.
off ends: the same of curves at places farther than 0.2 m from every end of a true curve, where walls meet or leap.
no truth: share of the map that lies farther than 0.3 m from every true curve."""


def line(row: Sequence[str]) -> str:
    """One line of the table, its columns as wide as their headers at least."""
    widths = [max(len(header), 6) for header in HEADERS]
    return "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))


def cells(name: str, trials: Sequence[TwinErrors]) -> tuple[str, ...]:
    """The figures of one trial, or means over many; the largest error is that of all."""
    values = summary(trials)
    poses, curves = pose_anees(trials), curve_anees(trials)
    return (
        name,
        str(values["scans"]),
        f"{1e3 * values['position_mean_m']:.1f}",
        f"{1e3 * values['position_largest_m']:.0f}",
        f"{values['heading_mean_deg']:.3f}",
        f"{1e3 * values['pose_graph_mean_m']:.1f}",
        f"{1e3 * values['adjusted_mean_m']:.1f}",
        f"{100 * values['improvement']:.0f} %",
        str(values["lost_key_scans"]),
        f"{values['chi2_per_dof']:.2f}",
        f"{poses.value:.2f}",
        f"{curves.value:.2f}",
        f"{curve_anees(trials, at_ends=False).value:.2f}",
        f"{100 * values['without_truth']:.1f} %",
        f"{values['processor_seconds']:.0f}",
    )


def summary(trials: Sequence[TwinErrors]) -> dict[str, Any]:
    """Means over trials, and the largest position error of all."""
    graph, adjusted = (_mean(getattr(trial, name).mean for trial in trials) for name in ("pose_graph", "adjusted"))
    return {
        "trials": len(trials),
        "scans": trials[0].scans,
        "position_mean_m": _mean(trial.position.mean for trial in trials),
        "position_largest_m": max(trial.position.maximum for trial in trials),
        "heading_mean_deg": math.degrees(_mean(trial.heading.mean for trial in trials)),
        "pose_graph_mean_m": graph,
        "adjusted_mean_m": adjusted,
        "improvement": 1.0 - adjusted / graph,
        "lost_key_scans": sum(trial.lost for trial in trials),
        "chi2_per_dof": _mean(trial.chi2_per_dof for trial in trials),
        "pose_anees": _figure(pose_anees(trials)),
        "curve_anees": _figure(curve_anees(trials)),
        "curve_anees_off_ends": _figure(curve_anees(trials, at_ends=False)),
        "without_truth": _mean(trial.curves.without_truth for trial in trials),
        "processor_seconds": _mean(trial.processor_seconds for trial in trials),
    }


def closing(trials: Sequence[TwinErrors]) -> str:
    """The last line of the table, the bands, and what the columns mean."""
    figures = {
        "pose ANEES": pose_anees(trials),
        "curve ANEES": curve_anees(trials),
        "off ends": curve_anees(trials, at_ends=False),
    }
    bands = ", ".join(f"{name} {_with_band(figure)}" for name, figure in figures.items())
    return f"{line(cells('all', trials))}\n\n{bands}\n{LEGEND}"


def figures(seeds: Sequence[int], trials: Sequence[TwinErrors]) -> dict[str, Any]:
    """All trials, and what they are together, as plain data."""
    return {"seeds": [_one(seed, trial) for seed, trial in zip(seeds, trials, strict=True)], "all": summary(trials)}


def _one(seed: int, trial: TwinErrors) -> dict[str, Any]:
    spreads = {name: asdict(getattr(trial, name)) for name in ("position", "adjusted", "pose_graph")}
    sizes = {"key_scans": trial.key_scans, "control_points": trial.control_points}
    return {"seed": seed} | sizes | spreads | summary([trial])


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _figure(figure: Figure) -> dict[str, Any]:
    return {"value": figure.value, "band": list(figure.band)}


def _with_band(figure: Figure) -> str:
    low, high = figure.band
    return f"{figure.value:.2f} ({low:.2f}–{high:.2f})"
