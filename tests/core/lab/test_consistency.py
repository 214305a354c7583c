"""One run of an experiment, and rows made of many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.backends import BACK_ENDS
from bspline_slam.errors import Cancelled
from bspline_slam.lab.consistency import (
    ASSOCIATIONS,
    BEARING_NOISE,
    FILTERS,
    ODOMETRY,
    RANGE_NOISE,
    Experiment,
    Problem,
    RunErrors,
    problem_from_truth,
    run_errors,
    run_once,
    settled,
    told_the_truth,
)
from bspline_slam.lab.consistency_table import summarise
from bspline_slam.lab.simulation import SimulatedLog, simulate
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import open_world


def honest(rng: np.random.Generator, boast: float = 1.0) -> RunErrors:
    """A run whose errors are Gaussian with the claimed covariance divided by `boast`."""
    position = rng.standard_normal((10, 3)) ** 2 * boast
    return RunErrors(
        scans=tuple(range(1, 11)),
        pose_nees=position.sum(1),
        inside=position[:, :2].sum(1) < 4.0,
        curve_nees=boast * rng.chisquare(40),
        curve_dof=40,
        chi2=rng.chisquare(500),
        dof=500.0,
        innovation=rng.chisquare(50),
        innovation_dof=50.0,
        position_error=0.01,
    )


def test_rows_tell_honest_covariances_from_boastful_ones() -> None:
    rng = np.random.default_rng(0)
    row = summarise(Experiment("world"), [honest(rng) for _ in range(100)])
    assert row.runs == 100
    assert row.pose.inside and row.curve.inside and row.chi2.inside and row.nis.inside and row.coverage.inside
    assert row.pose.band == pytest.approx((0.846, 1.166), abs=1e-3)
    boastful = summarise(Experiment("world"), [honest(rng, 2.0) for _ in range(100)])
    assert not (boastful.pose.inside or boastful.curve.inside or boastful.coverage.inside)


def test_runs_that_failed_or_have_no_innovation_count_nowhere() -> None:
    rng = np.random.default_rng(1)
    runs = [honest(rng), replace(honest(rng), innovation=np.nan, innovation_dof=np.nan)]
    row = summarise(Experiment("world"), runs, ["the solver gave up"])
    assert (row.runs, row.failed, row.problem) == (2, 1, "the solver gave up")
    assert row.nis.value == pytest.approx(runs[0].innovation / 50)
    nothing = summarise(Experiment("world"), [], ["the solver gave up"])
    assert nothing.runs == 0 and np.isnan(nothing.pose.value) and not nothing.pose.inside


@pytest.mark.parametrize("association", ASSOCIATIONS)
def test_a_run_is_about_as_good_as_it_says(association: str) -> None:
    run = run_once(Experiment("three_splines", association=association), np.random.default_rng(2))
    assert len(run.pose_nees) == len(run.inside) == len(run.scans) >= 15
    assert run.position_error < 0.01
    assert 0.2 < run.pose_nees.mean() / 3 < 4.0
    assert run.curve_dof > 30 and 0.4 < run.curve_nees / run.curve_dof < 2.0
    assert run.chi2 / run.dof == pytest.approx(1.0, abs=0.1)
    assert run.innovation / run.innovation_dof == pytest.approx(1.0, abs=0.5)


def test_the_published_model_is_sure_of_what_it_does_not_know() -> None:
    experiment = Experiment("three_splines", model="chord-length")
    run = run_once(experiment, np.random.default_rng(2))
    tangent_free = run_once(replace(experiment, model="normal-distance"), np.random.default_rng(2))
    assert run.position_error > 2 * tangent_free.position_error


@pytest.fixture(scope="module")
def corridor() -> tuple[World, SimulatedLog, Problem]:
    """A drive and the problem that truth makes of it: the same for every back end."""
    world = open_world("corridor")
    log = simulate(
        world, rng=np.random.default_rng(1), noise=RANGE_NOISE, bearing_noise=BEARING_NOISE, odometry=ODOMETRY
    )
    return world, log, problem_from_truth(world, log, told_the_truth(Experiment("corridor")))


@pytest.mark.parametrize("back_end", [name for name in BACK_ENDS if name != "pose_graph"])
def test_every_back_end_can_be_put_to_the_test(corridor: tuple[World, SimulatedLog, Problem], back_end: str) -> None:
    world, log, problem = corridor
    config = told_the_truth(Experiment("corridor", back_end=back_end))
    run = run_errors(world, log, problem, *settled(problem, config), config)
    assert np.all(np.isfinite(run.pose_nees)) and np.all(run.pose_nees >= 0.0)
    assert run.curve_dof > 10 and np.isfinite(run.curve_nees)
    assert np.isfinite(run.innovation) == np.isfinite(run.innovation_dof) == (back_end not in FILTERS)


def test_a_run_can_be_cancelled() -> None:
    with pytest.raises(Cancelled):
        run_once(Experiment("three_splines"), np.random.default_rng(0), lambda: True)
