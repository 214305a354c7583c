"""Curves keep the stretch that enough key scans saw, and lose knots without losing their place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam.adjustment.trimming import TrimmingConfig, agreed, supported_stretches, thinned, trimmed
from bspline_slam.fitting import FittingConfig
from bspline_slam.models import NormalDistance
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.spline_map import SplineMap
from core.mapped_room import PATH, seen_from


def test_support_keeps_what_two_poses_saw_and_ends_where_beams_do() -> None:
    config = TrimmingConfig(support=2, support_reach=0.2, gap=1.0)
    t = np.array([0.13, 0.17, 0.6, 0.7, 1.1, 3.1, 3.15, 3.22, 3.9])
    pose = np.array([0, 1, 0, 1, 0, 0, 1, 0, 0])
    apart = np.zeros(len(t))
    assert supported_stretches(t, pose, apart, config) == [(0.13, 0.7), (3.1, 3.22)]
    assert supported_stretches(t[:0], pose[:0], apart[:0], config) == []


def test_beams_of_one_pose_are_better_than_none() -> None:
    t = np.array([0.1, 0.15, 0.2, 0.5, 0.55])
    alone = supported_stretches(t, np.zeros(5, dtype=int), np.zeros(5), TrimmingConfig(support=2, gap=0.1))
    assert alone == [(0.1, 0.2), (0.5, 0.55)]


def test_the_order_of_beams_says_nothing() -> None:
    rng = np.random.default_rng(3)
    t, pose, apart = rng.uniform(0.0, 5.0, 200), rng.integers(0, 4, 200), rng.uniform(0.0, 0.2, 200)
    order = rng.permutation(200)
    config = TrimmingConfig()
    shuffled = supported_stretches(t[order], pose[order], apart[order], config)
    assert shuffled == supported_stretches(t, pose, apart, config)


def test_a_gap_that_beams_would_have_filled_parts_a_curve() -> None:
    config = TrimmingConfig(support=2, gap=0.1, gap_ratio=1.5)
    t = np.delete(np.arange(0.0, 4.001, 0.05), np.arange(25, 30))  # from 1.2 to 1.5
    t, pose = np.tile(t, 2), np.repeat([0, 1], len(t))
    stretches = supported_stretches(t, pose, np.full(len(t), 0.05), config)
    np.testing.assert_allclose(stretches, [(0.0, 1.2), (1.5, 4.0)])
    sparse = supported_stretches(t, pose, np.full(len(t), 0.25), config)
    np.testing.assert_allclose(sparse, [(0.0, 4.0)], err_msg="beams so far apart say nothing about a gap as wide")


def test_an_end_follows_its_beams_but_only_so_far() -> None:
    keys, splines, _ = seen_from(PATH)
    config = TrimmingConfig()
    walls = (spline for spline in splines if spline.length > 1.0)
    short = SplineMap(tuple(replace(s, span=(s.span[0] + 0.3, s.span[1] - 0.04)) for s in walls))
    sights = collect_sights(keys, short)
    feet = find_feet(sights, short, PATH, 0.1, config.reach)
    after = trimmed(short, sights, feet, config, NormalDistance())
    for cut, grown in zip(short, after, strict=True):
        assert cut.span[0] - config.reach <= grown.span[0]
        assert grown.span[1] <= cut.span[1] + config.reach
    longer = [grown.span[0] < cut.span[0] for cut, grown in zip(short, after, strict=True)]
    assert sum(longer) >= 4, "the four walls of the room go on"


def test_a_spline_of_which_hardly_anything_is_left_is_dropped() -> None:
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, PATH, 0.1)
    middle = [float(np.median(feet.t[feet.counts & (sights.spline == k)])) for k in range(len(splines))]
    wanted = np.abs(feet.t - np.array(middle)[sights.spline]) < np.where(sights.spline == 0, 0.01, np.inf)
    left = trimmed(splines, sights, replace(feet, counts=feet.counts & wanted), TrimmingConfig(), NormalDistance())
    assert splines.splines[0].id not in {spline.id for spline in left}
    assert len(left) == len(splines) - 1


def test_trimming_keeps_the_curve_where_it_stays() -> None:
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, PATH, 0.1)
    cut = trimmed(splines, sights, feet, TrimmingConfig(support=4), NormalDistance())
    for before, after in zip(splines, cut, strict=True):
        t = np.linspace(*after.span, 20)
        np.testing.assert_allclose(after.curve(t), before.curve(t), atol=1e-9)


def test_thinning_saves_control_points_on_the_straight_walls_of_a_room() -> None:
    keys, splines, _ = seen_from(PATH)
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, PATH, 0.1)
    thin = thinned(splines, sights, feet, PATH, TrimmingConfig(idle_gain=9.2), FittingConfig())
    assert thin.control_point_count < 0.7 * splines.control_point_count
    across = find_feet(sights, thin, PATH, 0.1).across
    assert np.sqrt(np.mean(np.square(across))) < 1.2 * np.sqrt(np.mean(np.square(feet.across)))


def test_what_was_left_out_before_stays_left_out() -> None:
    keys, splines, _ = seen_from(PATH)
    waved = SplineMap(tuple(replace(spline, left_out=1e-6) for spline in splines))
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, PATH, 0.1)
    seen = (sights, feet, PATH, TrimmingConfig(), FittingConfig())
    for once, again in zip(thinned(splines, *seen), thinned(waved, *seen), strict=True):
        assert once.left_out >= 0.0
        assert again.left_out == once.left_out + 1e-6
    for cut in trimmed(waved, sights, feet, TrimmingConfig(), NormalDistance()):
        assert cut.left_out == 1e-6


def test_what_beams_do_not_agree_on_is_not_of_the_map() -> None:
    keys, splines, _ = seen_from(PATH)
    sights, config = collect_sights(keys, splines), TrimmingConfig()
    feet = find_feet(sights, splines, PATH, 0.1)
    seen = (PATH, config, FittingConfig())
    one, before = splines.splines[1], agreed(splines, sights, feet, *seen)
    assert one in before.splines
    scattered = np.where((sights.spline == 1) & feet.counts, 0.05 * (-1.0) ** np.arange(len(feet.t)), feet.across)
    left = agreed(splines, sights, replace(feet, across=scattered), *seen)
    assert left.splines == tuple(spline for spline in before if spline is not one)
