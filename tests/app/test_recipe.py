"""What a person chooses for a run, as a configuration."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bspline_slam.backends import BACK_ENDS
from bspline_slam.observation import MODELS
from bspline_slam.slam import SlamConfig
from splinescope.recipe import Recipe


def test_choosing_nothing_is_the_default_configuration() -> None:
    assert Recipe().config() == SlamConfig()


@pytest.mark.parametrize("model", MODELS)
def test_every_choice_reaches_the_configuration(model: str) -> None:
    config = Recipe(model, "sam", 3, 0.7, 9).config()
    assert (config.model, config.back_end, config.fitting.degree) == (model, "sam", 2)
    assert (config.fitting.spacing, config.chord_length.control_points) == (0.7, 9)


@pytest.mark.parametrize("model", MODELS)
def test_another_estimator_makes_the_same_map_and_nothing_else_does(model: str) -> None:
    recipe = Recipe(model)
    assert all(recipe.same_map(replace(recipe, back_end=back_end)) for back_end in BACK_ENDS)
    assert not recipe.same_map(replace(recipe, order=recipe.order + 1))
    assert not Recipe(MODELS[0]).same_map(Recipe(MODELS[1]))


def test_what_a_model_does_not_ask_for_changes_no_map() -> None:
    spaced, counted = (Recipe(model) for model in MODELS)
    assert not spaced.same_map(replace(spaced, spacing=0.9))
    assert spaced.same_map(replace(spaced, control_points=7))
    assert not counted.same_map(replace(counted, control_points=7))
    assert counted.same_map(replace(counted, spacing=0.9))
