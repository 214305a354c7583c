"""The histogram of residuals."""

from __future__ import annotations

import numpy as np
import pytest

from splinescope.palette import DARK, LIGHT, Theme
from splinescope.quality import BINS
from splinescope.residual_picture import residual_picture


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
