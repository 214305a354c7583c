"""Grades of residuals: every stretch has one, and neighbours of the same grade become one line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app import views
from bspline_slam.lab.stretches import Stretches
from bspline_slam.spline_map import SplineMap
from splinescope.grades import (
    OBSERVATIONS,
    RESIDUALS,
    UNKNOWN,
    WIDTHS,
    Scale,
    ages,
    pieces,
    scale_of,
    shares,
    stretches_of,
    uncertainties,
)
from splinescope.palette import DARK, LIGHT, MINIMUM_CONTRAST, Theme, contrast_ratio, luminance
from splinescope.view import Colouring


def test_a_grade_holds_what_lies_up_to_its_edge() -> None:
    rms = np.array([0.0, 0.006, 0.0061, 0.012, 0.018, 0.5, np.nan])
    assert RESIDUALS.graded(rms).tolist() == [0, 0, 1, 2, 3, 4, UNKNOWN]


def test_the_lines_of_all_grades_cover_every_stretch_once() -> None:
    world = views.floor_map()
    stretches = views.stretches_along(world)
    lines = [line for grade in range(UNKNOWN, len(WIDTHS)) for line in stretches_of(stretches, RESIDUALS, grade)]
    assert len(lines) < len(stretches.value)
    for spline in world:
        mine = sorted(span for number, span in lines if number == spline.id)
        assert [a for a, _ in mine[1:]] == pytest.approx([b for _, b in mine[:-1]])
        assert (mine[0][0], mine[-1][1]) == pytest.approx(spline.span)


def test_lines_of_two_curves_are_never_joined() -> None:
    two = Stretches(np.array([1, 1, 2]), np.array([0.0, 0.2, 0.0]), np.array([0.2, 0.4, 0.3]), np.full(3, 0.007))
    assert stretches_of(two, RESIDUALS, 1) == [(1, (0.0, 0.4)), (2, (0.0, 0.3))]
    assert stretches_of(two, RESIDUALS, 0) == []


def test_shares_are_of_what_is_known() -> None:
    nothing = np.zeros(0)
    assert shares(Stretches(nothing.astype(np.int64), nothing, nothing, nothing), RESIDUALS).sum() == 0.0
    some = Stretches(np.zeros(4, np.int64), np.arange(4.0), np.arange(4.0) + 1, np.array([0.001, 0.001, 0.02, np.nan]))
    assert shares(some, RESIDUALS) == pytest.approx([2 / 3, 0, 0, 0, 1 / 3])


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_worse_grades_stand_out_more(theme: Theme) -> None:
    colours = [theme.graded(grade) for grade in range(len(WIDTHS))]
    contrasts = [contrast_ratio(colour, theme.background) for colour in colours]
    assert contrasts == sorted(contrasts) and contrasts[0] >= MINIMUM_CONTRAST
    lightness = [luminance(colour) for colour in colours]
    assert min(np.abs(np.diff(lightness))) > 0.005
    assert list(WIDTHS) == sorted(set(WIDTHS))


@pytest.mark.parametrize("scale", [RESIDUALS, uncertainties(np.full(3, 0.004)), OBSERVATIONS, ages(45.0), ages(2700.0)])
def test_every_scale_has_a_label_for_each_grade(scale: Scale) -> None:
    assert len(scale.labels) == len(set(scale.labels)) == len(scale.most) == len(WIDTHS)
    assert list(scale.most) == sorted(scale.most) and scale.most[-1] == np.inf


def test_scales_say_their_units() -> None:
    assert RESIDUALS.labels[1] == "6 to 9 mm"
    assert uncertainties(np.array([0.0015, np.nan])).labels[-1] == "above 5 mm"


@pytest.mark.parametrize("size", [1e-5, 0.0004, 0.0013, 0.03, 0.4, 7.0])
def test_grades_of_uncertainty_lie_around_what_there_is(size: float) -> None:
    values = size * np.random.default_rng(3).uniform(0.3, 3.0, 501)
    scale = uncertainties(np.append(values, np.nan))
    assert list(scale.most) == sorted(set(scale.most)) and len(scale.labels) == len(WIDTHS)
    if 0.0005 < size < 0.1:
        assert scale.graded(np.array([np.median(values)])).tolist() == [len(WIDTHS) // 2]
    assert uncertainties(1.001 * values).most == scale.most, "a small edit must not move the colours"
    assert scale.graded(np.array([np.nan])).tolist() == [UNKNOWN]
    assert ages(2700.0).labels[0] == "0 to 9 min"
    assert ages(45.0).labels[-1] == "36 to 45 s"


@pytest.mark.parametrize("colouring", [c for c in Colouring if c is not Colouring.SPLINE])
def test_every_colouring_covers_every_curve_once(colouring: Colouring) -> None:
    shown = views.map_view(np.random.default_rng(3))
    assert scale_of(shown, colouring) is not None
    spans = [piece for grade in range(UNKNOWN, len(WIDTHS)) for piece in pieces(shown, colouring, grade)]
    for spline in shown.map:
        mine = sorted(span for number, span in spans if number == spline.id)
        assert (mine[0][0], mine[-1][1]) == pytest.approx(spline.span)
        assert sum(b - a for a, b in mine) == pytest.approx(spline.span[1] - spline.span[0])


def test_what_is_not_measured_yet_colours_nothing() -> None:
    shown = replace(views.map_view(np.random.default_rng(3)), stretches=None, sigmas=None)
    for colouring in (Colouring.SPLINE, Colouring.RESIDUAL, Colouring.UNCERTAINTY):
        assert scale_of(shown, colouring) is None
        assert pieces(shown, colouring, 0) == []


def test_a_spline_keeps_its_colour_when_others_go() -> None:
    shown = views.map_view(np.random.default_rng(3))
    fewer = replace(shown, map=SplineMap(shown.map.splines[3:]))
    for colouring in (Colouring.AGE, Colouring.OBSERVATIONS):
        before = {n: g for g in range(len(WIDTHS)) for n, _ in pieces(shown, colouring, g)}
        after = {n: g for g in range(len(WIDTHS)) for n, _ in pieces(fewer, colouring, g)}
        assert after.items() <= before.items()
