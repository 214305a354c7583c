"""Fits: exact on exact data, honest covariance, chord length as the paper has it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.errors import GeometryError
from bspline_slam.fitting import (
    FittingConfig,
    beam_covariances,
    chord_length_parameters,
    fit,
    fit_parameters,
    uniform_through,
)


def wavy(m: int, length: float = 3.0) -> np.ndarray:
    x = np.linspace(0.0, length, m)
    return np.stack([x + 2.0, 1.0 + 0.2 * np.sin(1.5 * x)], -1)


@given(st.integers(2, 60))
def test_chord_length_runs_from_zero_to_one(m: int) -> None:
    t = chord_length_parameters(wavy(m))
    assert t[0] == 0.0
    assert t[-1] == pytest.approx(1.0)
    assert (np.diff(t) > 0).all()


@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_chord_length_does_not_depend_on_the_frame(angle: float, x: float, y: float) -> None:
    c, s = np.cos(angle), np.sin(angle)
    moved = wavy(30) @ np.array([[c, s], [-s, c]]) + [x, y]
    np.testing.assert_allclose(chord_length_parameters(moved), chord_length_parameters(wavy(30)), atol=1e-12)


def test_points_of_a_spline_at_known_parameters_give_its_control_points_back() -> None:
    rng = np.random.default_rng(3)
    knots = clamped_knots(8)
    truth = BSpline(3, knots, np.cumsum(rng.uniform(0.1, 0.5, (8, 2)), axis=0))
    t = np.linspace(0.0, 1.0, 80)
    found = fit_parameters(truth(t), t, knots, FittingConfig(stiffness=1e6))
    np.testing.assert_allclose(found.curve.control_points, truth.control_points, atol=1e-6)


def test_covariance_of_control_points_matches_many_runs() -> None:
    """At fixed parameters the fit is linear, so the sample covariance over 400 runs must agree within 25 %."""
    rng = np.random.default_rng(4)
    config = FittingConfig(stiffness=1e3)
    points, knots = wavy(60), clamped_knots(7)
    t = chord_length_parameters(points)
    root = np.linalg.cholesky(beam_covariances(points, config.range_noise, config.bearing_noise))
    runs = [
        fit_parameters(points + np.einsum("mij,mj->mi", root, rng.normal(size=points.shape)), t, knots, config)
        for _ in range(400)
    ]
    sample = np.cov(np.array([run.curve.control_points.ravel() for run in runs]).T)
    stated = runs[0].covariance
    np.testing.assert_allclose(np.sqrt(np.diag(sample)), np.sqrt(np.diag(stated)), rtol=0.25)


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_any_degree_follows_a_wave(degree: int) -> None:
    found = fit(wavy(120), FittingConfig(degree=degree))
    assert found.curve.degree == degree
    assert found.rms < 0.01
    assert np.linalg.eigvalsh(found.covariance).min() > -1e-12


def test_a_few_points_make_the_smallest_curve() -> None:
    found = fit(wavy(4, 0.3))
    assert len(found.curve.control_points) == 4


def test_one_point_is_no_curve() -> None:
    with pytest.raises(GeometryError, match="two distinct points"):
        fit(np.zeros((3, 2)))


def test_a_map_curve_is_labelled_by_arc_length() -> None:
    curve = uniform_through(wavy(100), FittingConfig())
    length = np.linalg.norm(np.diff(wavy(100), axis=0), axis=1).sum()
    t = np.linspace(0.3, length - 0.3, 50)
    np.testing.assert_allclose(np.linalg.norm(curve(t, 1), axis=1), 1.0, atol=0.05)
