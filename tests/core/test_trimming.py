"""Curves keep the stretch that enough key scans saw, and lose knots without losing their place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam.fitting import FittingConfig
from bspline_slam.models import NormalDistance
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.trimming import TrimmingConfig, supported_span, thinned, trimmed
from core.test_adjustment import PATH, seen_from


def test_support_keeps_the_longest_stretch_that_two_poses_saw() -> None:
    config = TrimmingConfig(support=2, support_step=0.5, gap=1.0)
    t = np.array([0.1, 0.1, 0.6, 0.6, 1.1, 3.1, 3.1, 3.6])
    pose = np.array([0, 1, 0, 1, 0, 0, 1, 0])
    apart = np.zeros(len(t))
    assert supported_span(t, pose, apart, (0.0, 4.0), config) == (0.0, 1.0)
    assert supported_span(t[:0], pose[:0], apart[:0], (0.0, 4.0), config) == (0.0, 4.0)


def test_no_curve_is_kept_across_a_gap_that_beams_would_have_filled() -> None:
    config = TrimmingConfig(support=2, gap=0.1, gap_ratio=1.5)
    t = np.delete(np.arange(0.0, 4.001, 0.05), np.arange(25, 30))  # from 1.2 to 1.5
    t, pose = np.tile(t, 2), np.repeat([0, 1], len(t))
    low, high = supported_span(t, pose, np.full(len(t), 0.05), (0.0, 4.0), config)
    np.testing.assert_allclose((low, high), (1.5, 4.0))
    sparse = supported_span(t, pose, np.full(len(t), 0.25), (0.0, 4.0), config)
    assert sparse == (0.0, 4.0), "beams so far apart say nothing about a gap as wide"


def test_no_end_is_kept_that_beams_would_have_reached() -> None:
    config = TrimmingConfig(support=1, support_step=4.0, gap=0.1)
    t = np.arange(0.3, 3.801, 0.05)
    span = supported_span(t, np.zeros(len(t), dtype=int), np.full(len(t), 0.05), (0.0, 4.0), config)
    np.testing.assert_allclose(span, (0.3, 3.8))


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
