"""Colours: legible on both grounds, stable, and never the only sign of a state."""

import re
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.colour_vision import VISIONS, distance, seen
from bspline_slam.association import Verdict
from splinescope.grades import WIDTHS
from splinescope.palette import (
    COMPARED_HUE,
    DARK,
    LIGHT,
    MINIMUM_CONTRAST,
    PURPLE,
    SHOWN_HUE,
    SPLINE_HUES,
    VERDICT_STYLES,
    VERMILION,
    Theme,
    contrast_ratio,
    hexadecimal,
    mix,
)
from splinescope.paths import static_folder

NOTICEABLE = 2.3  # ΔE that is just noticeable

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


@themes
@pytest.mark.parametrize("vision", VISIONS.values(), ids=VISIONS)
def test_hues_can_be_told_apart_in_any_vision(theme: Theme, vision: np.ndarray) -> None:
    verdicts = [theme.verdict(verdict) for verdict in Verdict]
    splines = [theme.spline(number) for number in range(len(SPLINE_HUES))]
    results = [theme.legible(SHOWN_HUE), theme.legible(COMPARED_HUE)]
    loops = [theme.legible(PURPLE), theme.legible(VERMILION)]
    for hues in (verdicts, splines, results, loops):
        assert min(distance(a, b, vision) for a, b in combinations(hues, 2)) > 4 * NOTICEABLE


@themes
@pytest.mark.parametrize("vision", VISIONS.values(), ids=VISIONS)
def test_a_ramp_runs_evenly_from_quiet_to_loud_in_any_vision(theme: Theme, vision: np.ndarray) -> None:
    ramp = [theme.graded(grade) for grade in range(len(WIDTHS))]
    lightness = np.array([seen(colour, vision)[0] for colour in ramp])
    steps = np.diff(lightness)
    assert (steps > 0).all() or (steps < 0).all()
    assert np.abs(steps).max() < 2.0 * np.abs(steps).min()
    assert min(distance(a, b, vision) for a, b in pairwise(ramp)) > 4 * NOTICEABLE


@pytest.mark.parametrize(("theme", "rule"), [(DARK, ":root {"), (LIGHT, ":root.scope-light {")], ids=["dark", "light"])
def test_texts_and_marks_of_the_style_sheet_are_legible(theme: Theme, rule: str) -> None:
    sheet = (static_folder() / "style.css").read_text(encoding="utf-8")
    block = sheet[sheet.index(rule) :].partition("}")[0]
    hexes = dict(re.findall(r"--scope-([a-z-]+): #([0-9a-f]{6});", block))
    colours = {name: np.frombuffer(bytes.fromhex(code), dtype=np.uint8) for name, code in hexes.items()}
    assert np.array_equal(colours["map"], theme.background)
    for name, least in (("ink", 7.0), ("quiet", 4.5), ("accent", 3.0), ("mark-loop", 3.0), ("mark-lost", 3.0)):
        assert contrast_ratio(colours[name], colours["map"]) >= least, name


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
