"""Curves keep the stretch that enough key scans saw, and lose knots without losing their place."""

from __future__ import annotations

import numpy as np

from bspline_slam.fitting import FittingConfig
from bspline_slam.models import NormalDistance
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.trimming import TrimmingConfig, supported_span, thinned, trimmed
from core.test_adjustment import PATH, seen_from


def test_support_keeps_the_longest_stretch_that_two_poses_saw() -> None:
    config = TrimmingConfig(support=2, support_step=0.5)
    t = np.array([0.1, 0.1, 0.6, 0.6, 1.1, 3.1, 3.1, 3.6])
    pose = np.array([0, 1, 0, 1, 0, 0, 1, 0])
    assert supported_span(t, pose, (0.0, 4.0), config) == (0.0, 1.0)
    assert supported_span(t[:0], pose[:0], (0.0, 4.0), config) == (0.0, 4.0)


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
