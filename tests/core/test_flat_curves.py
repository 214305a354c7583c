"""Curves as flat arrays say the same as the curves themselves."""

from __future__ import annotations

import numpy as np

from bspline_slam.bspline import BSpline, clamped_knots, uniform_knots
from bspline_slam.flat_curves import FlatCurves

RNG = np.random.default_rng(0)
CURVES = [
    BSpline(3, uniform_knots(0.0, 0.4, 9, 3), RNG.normal(size=(9, 2))),
    BSpline(1, uniform_knots(0.0, 2.0, 2, 1), RNG.normal(size=(2, 2))),
    BSpline(2, clamped_knots(5, 2), RNG.normal(size=(5, 2))),
]


def test_each_curve_keeps_its_own() -> None:
    flat = FlatCurves.of(CURVES)
    assert flat.order == 4
    for c, curve in enumerate(CURVES):
        mine = flat.control_points[flat.point_start[c] : flat.point_start[c + 1]]
        np.testing.assert_array_equal(mine, curve.control_points)
        np.testing.assert_array_equal(flat.knots[flat.knot_start[c] : flat.knot_start[c + 1]], curve.knots)
        assert flat.degrees[c] == curve.degree


def test_greville_abscissae_and_tangents_are_those_of_the_curves() -> None:
    abscissae, tangents = FlatCurves.of(CURVES).greville()
    np.testing.assert_allclose(abscissae, np.concatenate([curve.greville() for curve in CURVES]))
    across = np.concatenate([curve.normals(np.clip(curve.greville(), *curve.domain)) for curve in CURVES])
    np.testing.assert_allclose(tangents[:, ::-1] * (-1.0, 1.0), across, atol=1e-12)


def test_points_are_those_of_the_curves_beyond_their_domains_too() -> None:
    for share in (0.0, 0.37, 1.0, 1.05):
        t = np.array([low + share * (high - low) for low, high in (curve.domain for curve in CURVES)])
        expected = [curve(t[c : c + 1])[0] for c, curve in enumerate(CURVES)]
        np.testing.assert_allclose(FlatCurves.of(CURVES).points_at(t), expected, atol=1e-12)


def test_no_curve_is_fine() -> None:
    assert FlatCurves.of([]).points_at(np.zeros(0)).shape == (0, 2)
    assert len(FlatCurves.of([]).control_points) == 0
    assert FlatCurves.of([]).greville()[0].shape == (0,)
