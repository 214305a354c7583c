"""The panel knows every back end of the library, in its order."""

from __future__ import annotations

from bspline_slam.backends import BACK_ENDS
from splinescope.panels import optimise


def test_every_back_end_can_be_chosen_and_is_explained() -> None:
    assert tuple(optimise.BACK_ENDS) == BACK_ENDS
    assert all(text.endswith(".") for text in optimise.BACK_ENDS.values())
