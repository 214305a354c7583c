"""Edits as JSON, there and back, and what is refused."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.edits import edit as edits
from bspline_slam.errors import EditError
from core.edits.drawn import EDITS


@given(EDITS)
def test_an_edit_survives_json(edit: edits.Edit) -> None:
    assert edits.edit_from_dict(json.loads(json.dumps(edits.edit_to_dict(edit)))) == edit


@given(EDITS)
def test_every_edit_has_words(edit: edits.Edit) -> None:
    assert edits.in_words(edit)


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        ([1], "no edit"),
        ({"kind": "guess"}, "no edit"),
        ({"kind": "merge", "kept": 1}, "gone, kept"),
        ({"kind": "merge", "kept": 1, "gone": 2, "more": 3}, "gone, kept"),
        ({"kind": "merge", "kept": 1, "gone": "2"}, 'gone of the edit "merge" cannot be 2'),
        ({"kind": "merge", "kept": 1, "gone": 2.5}, "cannot be 2.5"),
        ({"kind": "merge", "kept": True, "gone": 2}, "cannot be True"),
        ({"kind": "pin pose", "scan": 1, "pose": [0.0, 1.0]}, "pose"),
        ({"kind": "pin pose", "scan": 1, "pose": [0.0, 1.0, float("nan")]}, "pose"),
    ],
)
def test_what_is_no_edit_is_refused_in_a_sentence(data: Any, complaint: str) -> None:
    with pytest.raises(EditError, match=complaint):
        edits.edit_from_dict(data)


def test_a_pinned_spline_keeps_its_curve() -> None:
    curve = BSpline(3, clamped_knots(6, 3), np.random.default_rng(1).normal(size=(6, 2)))
    pinned = edits.PinSpline.at(4, curve, (0.1, 0.9)).curve
    t = np.linspace(0, 1, 9)
    np.testing.assert_array_equal(pinned(t), curve(t))


def test_a_pinned_spline_of_impossible_numbers_is_refused() -> None:
    with pytest.raises(EditError, match="spline 4"):
        _ = edits.PinSpline(4, 3, (0.0, 1.0), ((0.0, 0.0),), (0.0, 1.0)).curve
