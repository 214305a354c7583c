"""Many runs of one experiment as one row: mean normalised errors, each with the band it should lie in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bspline_slam.lab.consistency import Experiment, RunErrors
from bspline_slam.lab.statistics import Band, binomial_band, chi_square_band

POSE_DOF = 3


@dataclass(frozen=True, slots=True)
class Figure:
    """A mean over runs, 1 or the expected share when covariances are honest, and its 95 % acceptance band."""

    value: float
    band: Band

    @property
    def inside(self) -> bool:
        return self.band[0] <= self.value <= self.band[1]


@dataclass(frozen=True, eq=False, slots=True)
class Row:
    """One experiment. `pose`, `curve`, `nis` and `chi2` are divided by their degrees of freedom.

    `by_scan` holds the mean pose NEES of each key scan that all runs share. `failed` runs count in no figure;
    `problem` is what the first of them said. `position_error` is the root mean square over all poses (m).
    """

    experiment: Experiment
    runs: int
    pose: Figure
    curve: Figure
    nis: Figure
    chi2: Figure
    coverage: Figure
    position_error: float
    by_scan: dict[int, float]
    failed: int = 0
    problem: str = ""


def summarise(experiment: Experiment, runs: Sequence[RunErrors], failures: Sequence[str] = ()) -> Row:
    """The row of an experiment.

    The poses of one run share their errors, so a run counts as one sample of three degrees of freedom, and as one
    trial of coverage: those bands hold at least 95 %. The bands of all others follow from the degrees of freedom.
    """
    count = len(runs)
    innovations = [run for run in runs if np.isfinite(run.innovation)]
    return Row(
        experiment=experiment,
        runs=count,
        pose=Figure(_mean([float(run.pose_nees.mean()) / POSE_DOF for run in runs]), _band(POSE_DOF * count)),
        curve=_ratio([run.curve_nees for run in runs], [run.curve_dof for run in runs]),
        nis=_ratio([run.innovation for run in innovations], [run.innovation_dof for run in innovations]),
        chi2=_ratio([run.chi2 for run in runs], [run.dof for run in runs]),
        coverage=Figure(
            _mean([float(run.inside.mean()) for run in runs]), binomial_band(count) if count else (np.nan, np.nan)
        ),
        position_error=float(np.sqrt(_mean([run.position_error**2 for run in runs]))),
        by_scan=_by_scan(runs),
        failed=len(failures),
        problem=failures[0] if failures else "",
    )


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def _band(dof: float) -> Band:
    return chi_square_band(dof) if dof > 0 else (float("nan"), float("nan"))


def _ratio(values: Sequence[float], dofs: Sequence[float]) -> Figure:
    """Sum of χ² values over the sum of their degrees of freedom."""
    dof = float(np.sum(dofs))
    return Figure(float(np.sum(values)) / dof if dof > 0 else float("nan"), _band(dof))


def _by_scan(runs: Sequence[RunErrors]) -> dict[int, float]:
    """Mean NEES over its degrees of freedom of each key scan that every run has."""
    if not runs:
        return {}
    shared = sorted(set.intersection(*(set(run.scans) for run in runs)))
    nees = np.array([[run.pose_nees[run.scans.index(scan)] for scan in shared] for run in runs])
    return dict(zip(shared, (nees.mean(axis=0) / POSE_DOF).tolist(), strict=True))
