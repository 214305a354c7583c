"""Walls that a map shows twice: curves that run side by side and face the same way."""

from __future__ import annotations

import numpy as np

from bspline_slam.curve_samples import CurveSamples
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.alongside import alongside

SPACING = 0.02
"""Distance (m) between the samples of a curve."""
WITHIN = 0.08
"""Curves farther apart than this (m) may well be two surfaces."""


def double_walls(splines: SplineMap) -> float:
    """Metres of curve that lie beside a longer curve: what there would be less if each wall were one curve."""
    if len(splines) == 0:
        return 0.0
    samples = CurveSamples.of(splines.splines, SPACING)
    lengths = np.array([spline.length for spline in splines])
    rank = np.empty(len(splines), dtype=np.int64)
    rank[np.argsort(lengths, kind="stable")] = np.arange(len(splines))
    found = alongside(samples, WITHIN)
    lesser = rank[samples.owner[found.sample]] < rank[samples.owner[found.beside]]
    doubled = np.bincount(samples.owner[np.unique(found.sample[lesser])], minlength=len(splines))
    return float((doubled / np.diff(samples.first) * lengths).sum())
