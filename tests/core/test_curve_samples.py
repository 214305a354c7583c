"""Samples of curves: those near a place that face the same way, found as by looking at each of them."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.curve_samples import CurveSamples
from bspline_slam.spline_map import MapSpline

RNG = np.random.default_rng(2)


def some_curve(number: int) -> MapSpline:
    steps = RNG.normal(0.0, 0.5, (7, 2))
    curve = BSpline(3, uniform_knots(0.0, 0.5, 7, 3), RNG.uniform(0.0, 2.0, 2) + np.cumsum(steps, axis=0))
    return MapSpline(number, curve, (0.1, 1.9), 0)


CURVES = [some_curve(k) for k in range(12)]
SAMPLES = CurveSamples.of(CURVES, 0.05)


def test_every_curve_has_its_row_of_samples() -> None:
    assert SAMPLES.first[-1] == len(SAMPLES.t) == len(SAMPLES.owner)
    for k, curve in enumerate(CURVES):
        mine = slice(int(SAMPLES.first[k]), int(SAMPLES.first[k + 1]))
        assert np.all(SAMPLES.owner[mine] == k)
        np.testing.assert_allclose(SAMPLES.points[mine], curve.curve(SAMPLES.t[mine]), atol=1e-9)
        ends = np.array([mine.start, mine.stop - 1])
        np.testing.assert_array_equal(SAMPLES.near(SAMPLES.owner[ends], SAMPLES.t[ends]), ends)


@pytest.mark.parametrize(("within", "agree", "most"), [(0.2, 0.05, 1), (0.3, 0.9, 3), (0.05, -1.0, 4)])
def test_samples_that_face_the_same_way_are_found_as_by_looking_at_each(within: float, agree: float, most: int) -> None:
    rng = np.random.default_rng(5)
    points, angle = rng.uniform(-1.0, 3.0, (200, 2)), rng.uniform(-np.pi, np.pi, 200)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    found = SAMPLES.facing(points, normals, within, agree, most)
    distance = np.linalg.norm(points[:, None] - SAMPLES.points, axis=-1)
    distance[(distance > within) | (normals @ SAMPLES.normals.T < agree)] = np.inf
    of_curves = np.stack([distance[:, SAMPLES.owner == k].min(1) for k in range(len(CURVES))], axis=1)
    expected = np.sort(of_curves, axis=1)[:, :most]
    here = np.where(found >= 0, np.take_along_axis(distance, np.maximum(found, 0), axis=1), np.inf)
    np.testing.assert_array_equal(here, expected)
    assert np.isfinite(expected).any() and np.isinf(expected).any()


def test_apart_is_across_and_along() -> None:
    sample = np.arange(0, len(SAMPLES.t), 7)
    tangents = SAMPLES.normals[sample][:, ::-1] * (1.0, -1.0)
    points = SAMPLES.points[sample] + 0.3 * SAMPLES.normals[sample] - 0.2 * tangents
    across, along = SAMPLES.apart(points, sample)
    np.testing.assert_allclose(across, 0.3, atol=1e-12)
    np.testing.assert_allclose(along, -0.2, atol=1e-12)
