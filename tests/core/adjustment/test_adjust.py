"""Spline adjustment: brings disturbed poses back, by either model and every back end, and says what holds what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.adjustment.adjust import adjust_splines, foreseen
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.adjustment.spline_graph import build_graph
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.errors import Cancelled
from bspline_slam.models import ChordLength, NormalDistance
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.spline_map import SplineMap
from core.mapped_room import MODEL, PATH, disturbed, seen_from


def nobody(fraction: float, record: IterationRecord | None) -> None:
    """Progress that nobody watches."""


def error(poses: np.ndarray) -> float:
    """Median distance of the poses from the truth (m): one scan of the disturbed map may be given to wrong curves."""
    off = se2.between(PATH, poses)
    return float(np.median(np.hypot(off[:, 0], off[:, 1])))


@pytest.mark.parametrize("name", ["direct", "sam"])
def test_disturbed_poses_come_back(name: str) -> None:
    start = disturbed(0.03)
    keys, splines, factors = seen_from(start)
    _, estimate = adjust_splines(keys, start, splines, factors, AdjustmentConfig(), MODEL, name, nobody)
    assert error(start) > 0.02
    assert error(estimate.poses) < 0.005
    assert estimate.chi2 / estimate.dof < 2.0


def test_direct_and_sam_reach_the_same_optimum() -> None:
    start = disturbed(0.03)
    keys, splines, factors = seen_from(start)
    both = [
        adjust_splines(keys, start, splines, factors, AdjustmentConfig(gates=(0.1,)), MODEL, name, nobody)[1]
        for name in ("direct", "sam")
    ]
    np.testing.assert_allclose(both[0].poses, both[1].poses, atol=1e-6)
    np.testing.assert_allclose(both[0].control_points, both[1].control_points, atol=1e-5)


def test_the_paper_s_model_runs_on_the_same_factors_and_is_the_worse_one() -> None:
    start = disturbed(0.02)
    config, errors = AdjustmentConfig(gates=(0.15, 0.1)), []
    for model in (NormalDistance(), ChordLength()):
        keys, splines, factors = seen_from(start, model=model)
        estimate = adjust_splines(keys, start, splines, factors, config, model, "direct", nobody)[1]
        assert estimate.converged
        errors.append(error(estimate.poses))
    assert errors[0] < errors[1] < 0.1


def test_the_optimum_moves_with_the_world() -> None:
    move = np.array([4.0, -3.0, 0.8])
    start = disturbed(0.02)
    config = AdjustmentConfig(gates=(0.1, 0.1))
    keys, splines, factors = seen_from(start)
    here = adjust_splines(keys, start, splines, factors, config, MODEL, "direct", nobody)[1]
    moved = se2.compose(move, start)
    keys, splines, factors = seen_from(moved)
    there = adjust_splines(keys, moved, splines, factors, config, MODEL, "direct", nobody)[1]
    np.testing.assert_allclose(se2.between(se2.compose(move, here.poses), there.poses), 0.0, atol=1e-4)


def test_beams_behind_a_curve_or_beyond_its_end_do_not_count() -> None:
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, PATH, 0.1)
    assert feet.counts.mean() > 0.9
    assert np.abs(feet.across[feet.counts]).max() < 0.1
    turned = se2.compose(PATH, np.array([0.0, 0.0, np.pi]))
    assert find_feet(sights, splines, turned, 0.1).counts.mean() < 0.5


def test_matching_counts_only_for_what_no_spline_says() -> None:
    """All four walls tell of every pose; with one straight wall alone, matching keeps its say along that."""
    keys, splines, factors = seen_from(PATH)
    factors = [replace(f, kind="matching") for f in factors]
    sights = collect_sights(keys, splines)
    graph = build_graph(keys, PATH, splines, factors, sights, AdjustmentConfig(), MODEL, 0.1)
    for before, after in zip(factors, graph.pose_factors, strict=True):
        assert np.linalg.norm(after.sqrt_information) < 0.2 * np.linalg.norm(before.sqrt_information)
    wall = max(splines, key=lambda spline: spline.length)
    alone = SplineMap((wall,))
    seen = collect_sights(keys, alone)
    graph = build_graph(keys, PATH, alone, factors, seen, AdjustmentConfig(), MODEL, 0.1)
    observed = {factor.pose for factor in graph.spline_factors if factor.readings > 20}
    _, _, axes = np.linalg.svd(wall.curve.control_points - wall.curve.control_points.mean(0))
    compared = 0
    for before, after in zip(factors, graph.pose_factors, strict=True):
        if after.j not in observed:
            continue
        share = [np.linalg.norm(after.sqrt_information[:, :2] @ way) for way in se2.rotate(-PATH[after.j], axes)]
        share /= np.linalg.norm(before.sqrt_information[:, :2], axis=0).max()
        assert share[0] > 0.8
        assert share[1] < 0.3
        compared += 1
    assert compared > 2


def test_a_spline_that_nobody_sees_is_not_in_the_graph() -> None:
    keys, splines, factors = seen_from(PATH)
    gone = splines.splines[0].id
    blind = [replace(key, associations=tuple(a for a in key.associations if a.spline != gone)) for key in keys]
    graph = build_graph(blind, PATH, splines, factors, collect_sights(blind, splines), AdjustmentConfig(), MODEL, 0.1)
    assert gone not in graph.spline_ids
    assert len(graph.spline_ids) == len(splines) - 1


def test_cancelling_leaves_by_its_own_error() -> None:
    keys, splines, factors = seen_from(PATH)
    with pytest.raises(Cancelled):
        adjust_splines(keys, PATH, splines, factors, AdjustmentConfig(), MODEL, "direct", nobody, lambda: True)


def test_poses_are_foreseen_to_a_centimetre() -> None:
    start = disturbed(0.03)
    keys, splines, factors = seen_from(start)
    told = foreseen(keys, start, splines, factors, AdjustmentConfig(), MODEL, "direct").estimate
    _, estimate = adjust_splines(keys, start, splines, factors, AdjustmentConfig(), MODEL, "direct", nobody)
    off = se2.between(estimate.poses, told.poses)
    assert np.median(np.hypot(off[:, 0], off[:, 1])) < 0.01
