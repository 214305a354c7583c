"""Grades of residuals: every stretch has one, and neighbours of the same grade become one line."""

from __future__ import annotations

import numpy as np
import pytest

from app import views
from bspline_slam.lab.stretches import Stretches
from splinescope.grades import GRADES, UNKNOWN, graded, shares, stretches_of
from splinescope.palette import DARK, LIGHT, MINIMUM_CONTRAST, Theme, contrast_ratio, luminance


def test_a_grade_holds_what_lies_up_to_its_edge() -> None:
    rms = np.array([0.0, 0.006, 0.0061, 0.012, 0.018, 0.5, np.nan])
    assert graded(rms).tolist() == [0, 0, 1, 2, 3, 4, UNKNOWN]


def test_the_lines_of_all_grades_cover_every_stretch_once() -> None:
    world = views.floor_map()
    stretches = views.stretches_along(world)
    lines = [line for grade in range(UNKNOWN, len(GRADES)) for line in stretches_of(stretches, grade)]
    assert len(lines) < len(stretches.rms)
    for spline in world:
        mine = sorted(span for number, span in lines if number == spline.id)
        assert [a for a, _ in mine[1:]] == pytest.approx([b for _, b in mine[:-1]])
        assert (mine[0][0], mine[-1][1]) == pytest.approx(spline.span)


def test_lines_of_two_curves_are_never_joined() -> None:
    two = Stretches(np.array([1, 1, 2]), np.array([0.0, 0.2, 0.0]), np.array([0.2, 0.4, 0.3]), np.full(3, 0.007))
    assert stretches_of(two, 1) == [(1, (0.0, 0.4)), (2, (0.0, 0.3))]
    assert stretches_of(two, 0) == []


def test_shares_are_of_what_is_known() -> None:
    nothing = np.zeros(0)
    assert shares(Stretches(nothing.astype(np.int64), nothing, nothing, nothing)).sum() == 0.0
    some = Stretches(np.zeros(4, np.int64), np.arange(4.0), np.arange(4.0) + 1, np.array([0.001, 0.001, 0.02, np.nan]))
    assert shares(some) == pytest.approx([2 / 3, 0, 0, 0, 1 / 3])


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_worse_grades_stand_out_more(theme: Theme) -> None:
    colours = [theme.graded(grade) for grade in range(len(GRADES))]
    contrasts = [contrast_ratio(colour, theme.background) for colour in colours]
    assert contrasts == sorted(contrasts) and contrasts[0] >= MINIMUM_CONTRAST
    lightness = [luminance(colour) for colour in colours]
    assert min(np.abs(np.diff(lightness))) > 0.005
    assert [grade.width for grade in GRADES] == sorted({grade.width for grade in GRADES})
