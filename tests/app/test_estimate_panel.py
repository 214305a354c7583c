"""The panel knows every back end and every model of the library, in their order."""

from __future__ import annotations

from bspline_slam.backends import BACK_ENDS
from bspline_slam.observation import MODELS
from splinescope.panels import estimate


def test_every_back_end_and_every_model_can_be_chosen_and_is_explained() -> None:
    assert tuple(estimate.ABOUT_BACK_ENDS) == BACK_ENDS
    assert tuple(estimate.ABOUT_MODELS) == MODELS
    for texts in (estimate.ABOUT_BACK_ENDS, estimate.ABOUT_MODELS):
        assert all(text.endswith(".") for text in texts.values())
