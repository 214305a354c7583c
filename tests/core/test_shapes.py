"""The shapes in the signatures are really checked while testing."""

from __future__ import annotations

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from bspline_slam import se2
from bspline_slam.scan import LaserScan


def test_a_wrong_shape_is_caught_in_a_function() -> None:
    with pytest.raises(TypeCheckError):
        se2.compose(np.zeros(2), np.zeros(3))


def test_a_wrong_shape_is_caught_in_a_value() -> None:
    with pytest.raises(TypeCheckError):
        LaserScan(0, 0.0, np.zeros(4), np.zeros(5), 0.0, 1.0, np.zeros(3))


def test_a_whole_number_passes_for_a_float() -> None:
    assert LaserScan(0, 0, np.zeros(4), np.zeros(4), 0, 1, np.zeros(3)).range_max == 1
