"""Colours: legible on both grounds, stable, and never the only sign of a state."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.association import Verdict
from splinescope.palette import DARK, LIGHT, MINIMUM_CONTRAST, VERDICT_STYLES, Theme, contrast_ratio, hexadecimal, mix

colours = st.tuples(*[st.integers(0, 255)] * 3).map(lambda c: np.array(c, dtype=np.uint8))
themes = pytest.mark.parametrize("theme", [DARK, LIGHT], ids=["dark", "light"])


@themes
@given(hue=colours)
def test_any_hue_becomes_legible(theme: Theme, hue: np.ndarray) -> None:
    assert contrast_ratio(theme.legible(hue), theme.background) >= MINIMUM_CONTRAST


@themes
@given(spline_id=st.integers(0, 10**6))
def test_splines_are_legible_and_keep_their_colour(theme: Theme, spline_id: int) -> None:
    colour = theme.spline(spline_id)
    assert contrast_ratio(colour, theme.background) >= MINIMUM_CONTRAST
    assert np.array_equal(colour, theme.spline(spline_id))


@themes
def test_splines_made_one_after_another_differ(theme: Theme) -> None:
    hues = [tuple(theme.spline(i).tolist()) for i in range(7)]
    assert len(set(hues)) == 7


def test_every_verdict_has_a_style_of_its_own() -> None:
    assert set(VERDICT_STYLES) == set(Verdict)
    assert len({style.glyph for style in VERDICT_STYLES.values()}) == len(Verdict)
    assert len({(style.line, hexadecimal(style.hue)) for style in VERDICT_STYLES.values()}) == len(Verdict)


@given(a=colours, b=colours)
def test_contrast_is_symmetric_and_at_least_one(a: np.ndarray, b: np.ndarray) -> None:
    assert contrast_ratio(a, b) == contrast_ratio(b, a) >= 1.0
    assert contrast_ratio(a, a) == 1.0


def test_black_on_white_has_the_largest_contrast() -> None:
    black, white = np.zeros(3, np.uint8), np.full(3, 255, np.uint8)
    assert contrast_ratio(black, white) == pytest.approx(21.0)


@given(a=colours, b=colours)
def test_a_mixture_runs_from_one_to_the_other(a: np.ndarray, b: np.ndarray) -> None:
    assert np.array_equal(mix(a, b, 0.0), a)
    assert np.array_equal(mix(a, b, 1.0), b)
