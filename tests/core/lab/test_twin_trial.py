"""Trials on a twin: what they report when the estimate is the truth, and when it is off by a known amount."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.lab.disturbances import DisturbanceModel
from bspline_slam.lab.evaluation import Figures
from bspline_slam.lab.simulation import SimulatedLog
from bspline_slam.lab.twin import Twin, simulate_twin
from bspline_slam.lab.twin_trial import TwinErrors, aligned_errors, curve_anees, pose_anees, run_trial, twin_errors
from bspline_slam.slam import run_slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import SplineMap
from core.rooms import twin_room

CONFIG = SlamConfig()
NOBODY = DisturbanceModel(blocked_every=0, person_every=0)


@cache
def estimated() -> tuple[Twin, SimulatedLog, Snapshot]:
    twin = twin_room()
    log = simulate_twin(twin, rng=np.random.default_rng(1), disturbances=NOBODY)
    return twin, log, run_slam(log, CONFIG).snapshot


@cache
def errors() -> TwinErrors:
    return twin_errors(*estimated(), CONFIG, 1.5)


def test_the_pipeline_finds_the_drive_and_the_room() -> None:
    found = errors()
    assert found.scans == 60 and 3 <= found.key_scans <= 60
    assert found.position.maximum < 0.05 and found.heading.maximum < 0.02
    assert found.curves.without_truth == 0.0 and found.lost == 0
    assert len(found.pose_nees) == found.key_scans and len(found.curves.squares) == len(found.curves.splines) >= 3
    assert found.improvement == pytest.approx(1 - found.adjusted.mean / found.pose_graph.mean)


def test_where_the_truth_lies_as_a_whole_does_not_matter() -> None:
    twin, log, snapshot = estimated()
    move = np.array([3.0, -1.0, 2.0])
    moved = replace(
        twin, curves=tuple(c.with_control_points(se2.transform(move, c.control_points)) for c in twin.curves)
    )
    found = twin_errors(moved, replace(log, true_poses=se2.compose(move, log.true_poses)), snapshot, CONFIG, 1.5)
    assert found.position.mean == pytest.approx(errors().position.mean, abs=1e-9)
    assert np.allclose(found.pose_nees, errors().pose_nees)
    assert np.allclose(
        found.curves.squares, errors().curves.squares, rtol=0.05, atol=0.01
    )  # other samples of the truth


def test_a_map_that_is_off_shows_in_the_curves_alone() -> None:
    twin, log, snapshot = estimated()
    off = [replace(s, curve=s.curve.with_control_points(s.curve.control_points + 0.1)) for s in snapshot.map]
    found = twin_errors(twin, log, replace(snapshot, map=SplineMap(tuple(off))), CONFIG, 1.5)
    assert curve_anees([found]).value > 10 * curve_anees([errors()]).value
    assert np.array_equal(found.pose_nees, errors().pose_nees)


def test_curves_that_nothing_stands_for_are_counted() -> None:
    twin, log, snapshot = estimated()
    found = twin_errors(replace(twin, curves=twin.curves[:1]), log, snapshot, CONFIG, 1.5)
    assert 0.3 < found.curves.without_truth < 1.0
    assert set(found.curves.splines) < set(errors().curves.splines)


def test_bands_narrow_with_the_number_of_trials() -> None:
    for anees in (pose_anees, curve_anees):
        one, four = anees([errors()]), anees([errors()] * 4)
        assert one.value == pytest.approx(four.value)
        assert one.band[0] < four.band[0] < 1 < four.band[1] < one.band[1]


def test_rigid_motion_is_no_error() -> None:
    rng = np.random.default_rng(4)
    truth = rng.uniform(-3, 3, (20, 3))
    off = aligned_errors(se2.compose(np.array([1.0, 5.0, -2.0]), truth), truth)
    assert np.abs(off).max() < 1e-9
    assert Figures.of(np.linalg.norm(off[:, :2], axis=1)).maximum < 1e-9


def test_a_trial_is_decided_by_its_seed() -> None:
    short = twin_room().stretch(0, 12)
    one, two, other = (run_trial(short, np.random.default_rng(seed), CONFIG) for seed in (1, 1, 2))
    assert one.position == two.position != other.position


def test_places_at_ends_of_true_curves_can_be_left_out() -> None:
    twin, log, snapshot = estimated()
    halves = [c.clamped(half) for c in twin.curves for half in ((c.domain[0], 0.5), (0.5, c.domain[1]))]
    cut = twin_errors(replace(twin, curves=tuple(halves)), log, snapshot, CONFIG, 1.5)
    assert not errors().curves.at_end.all() and errors().curves.at_end.sum() < cut.curves.at_end.sum() < 20
    away = curve_anees([cut], at_ends=False)
    assert away.value == pytest.approx(cut.curves.squares[~cut.curves.at_end].mean())
    assert curve_anees([errors()]).value == pytest.approx(curve_anees([cut]).value, rel=0.1)
