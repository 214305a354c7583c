"""Uncertainty across curves: as large as samples scatter, blind to what happens along them."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.lab.certainty import sigma_across, sigmas_along
from bspline_slam.spline_map import MapSpline, SplineMap


def bent(rng: np.random.Generator) -> BSpline:
    x = np.linspace(0.0, 3.0, 8)
    return BSpline(3, uniform_knots(0.0, 0.5, 8), np.stack([x, np.sin(x)], axis=1) + rng.normal(0.0, 0.02, (8, 2)))


def test_sigma_is_what_samples_scatter_across_the_curve() -> None:
    rng = np.random.default_rng(1)
    curve, root = bent(rng), rng.normal(0.0, 0.003, (16, 16))
    t = np.linspace(*curve.domain, 7)
    drawn = root @ rng.normal(0.0, 1.0, (16, 20000))
    points = np.einsum("mn,nij->mij", curve.basis(t), drawn.reshape(8, 2, -1))
    across = np.einsum("mij,mi->mj", points, curve.normals(t))
    assert sigma_across(curve, root @ root.T, t) == pytest.approx(across.std(axis=1), rel=0.03)


def test_what_slides_a_straight_curve_along_itself_does_not_count() -> None:
    points = np.stack([np.linspace(0.0, 3.0, 8), np.zeros(8)], axis=1)
    curve = BSpline(3, uniform_knots(0.0, 0.5, 8), points)
    covariance = np.kron(np.eye(8), np.diag([1.0, 0.0]))
    assert sigma_across(curve, covariance, np.linspace(*curve.domain, 5)) == pytest.approx(0.0, abs=1e-12)


def test_stretches_of_a_spline_without_covariance_are_not_known() -> None:
    rng = np.random.default_rng(2)
    splines = SplineMap(tuple(MapSpline(i, c := bent(rng), c.domain, 0) for i in (4, 7)))
    found = sigmas_along(splines, {7: 1e-4 * np.eye(16)})
    assert np.isnan(found.value[found.spline == 4]).all()
    assert (found.value[found.spline == 7] <= 0.01).all()


def test_what_a_curve_leaves_out_is_as_uncertain_everywhere() -> None:
    rng = np.random.default_rng(3)
    curve = bent(rng)
    t = np.linspace(*curve.domain, 5)
    plain, straying = (sigma_across(curve, 1e-6 * np.eye(16), t, left_out) for left_out in (0.0, 4e-6))
    assert straying**2 - plain**2 == pytest.approx(4e-6)
