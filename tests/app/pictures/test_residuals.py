"""The histogram of residuals."""

from __future__ import annotations

import re

import numpy as np
import pytest

from splinescope.grades import WIDTHS
from splinescope.palette import DARK, LIGHT, Theme
from splinescope.pictures.residuals import grades_picture, residual_picture
from splinescope.quality import BINS
from splinescope.typeset import typeset


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_every_bin_that_holds_beams_has_a_bar(theme: Theme) -> None:
    counts = np.zeros(BINS, dtype=np.int64)
    counts[[0, 19, 20, 39]] = [1, 700, 900, 2]
    drawn = residual_picture(counts, theme)
    assert drawn.count("<polygon") == 4
    assert drawn.count('opacity="0.45"') == 2
    assert "1,603 beam ends" in drawn


def test_an_empty_histogram_is_only_its_axis() -> None:
    drawn = residual_picture(np.zeros(BINS, dtype=np.int64), DARK)
    assert "<polygon" not in drawn and "nan" not in drawn


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_the_key_to_grades_has_a_colour_and_a_width_for_each(theme: Theme) -> None:
    drawn = grades_picture(np.array([0.04, 0.25, 0.55, 0.15, 0.01]), theme)
    strokes = re.findall(r'stroke="(#\w+)" stroke-width="([\d.]+)"', drawn)
    assert len({colour for colour, _ in strokes}) == len({width for _, width in strokes}) == len(WIDTHS)
    assert typeset("55%") in drawn and typeset("9 to 12 mm") in drawn
