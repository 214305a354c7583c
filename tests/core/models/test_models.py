"""What every observation model promises, and which configurations none can be made of."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline
from bspline_slam.errors import ConfigError
from bspline_slam.fitting import FittingConfig, cumulated_chords
from bspline_slam.models import ChordLengthConfig, Model, make_model
from bspline_slam.observation import MODELS

DEGREES = range(1, 6)


def made(name: str, degree: int = 3, control_points: int = 13) -> Model:
    return make_model(name, FittingConfig(degree=degree), ChordLengthConfig(control_points))


def bent(length: float, count: int = 80) -> np.ndarray:
    x = np.linspace(0.0, length, count)
    return np.stack([x, 0.2 * np.sin(x)], -1)


def distance(curve: BSpline, points: np.ndarray) -> float:
    """Largest distance of points from a curve (m)."""
    return float(np.linalg.norm(curve(curve.foot_points(points)) - points, axis=1).max())


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("degree", DEGREES)
def test_curves_pass_by_their_points_and_parameters_are_metres(name: str, degree: int) -> None:
    points = bent(4.0)
    curve = made(name, degree).through(points)
    assert curve.degree == degree
    assert distance(curve, points) < 0.02
    length = cumulated_chords(points)
    np.testing.assert_allclose(curve(length), points, atol=0.02)
    assert curve.domain[0] == 0.0
    assert curve.domain[1] >= length[-1] - 1e-9


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize("count", [2, 4, 9])
def test_a_few_points_are_enough(name: str, degree: int, count: int) -> None:
    points = bent(0.5, count)
    assert distance(made(name, degree).through(points), points) < 0.02


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("degree", DEGREES)
def test_cutting_keeps_the_stretch_and_its_parameters(name: str, degree: int) -> None:
    model = made(name, degree)
    curve, span = model.through(bent(4.0)), (0.7, 2.9)
    t = np.linspace(*span, 30)
    np.testing.assert_allclose(model.cut(curve, span)(t), curve(t), atol=0.01)


@pytest.mark.parametrize("name", MODELS)
def test_the_plainest_curve_follows_its_points(name: str) -> None:
    points = bent(4.0)
    assert distance(made(name).plainest(points, 1e-3), points) < 5e-3


def test_a_straight_wall_needs_one_piece_where_the_model_chooses() -> None:
    wall = np.stack([np.linspace(0.0, 5.0, 50), np.zeros(50)], -1)
    assert len(made("normal-distance").plainest(wall, 1e-3).control_points) == 4
    assert len(made("chord-length").plainest(wall, 1e-3).control_points) == 13


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("degree", [0, 6])
def test_degrees_from_one_to_five_are_offered(name: str, degree: int) -> None:
    with pytest.raises(ConfigError, match=f"a degree from 1 to 5, not {degree}"):
        made(name, degree)


def test_a_spline_has_more_control_points_than_its_degree() -> None:
    with pytest.raises(ConfigError, match="at least 5 control points, not 4"):
        made("chord-length", degree=4, control_points=4)
    assert made("normal-distance", degree=4, control_points=4).fitting.degree == 4


def test_an_unknown_model_is_refused() -> None:
    with pytest.raises(ConfigError, match='no model "spline": choose one of normal-distance, chord-length'):
        made("spline")
