"""The map made tidy before it is adjusted: what shows one wall twice becomes one spline, and what a gap cuts off a
spline of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.adjustment.trimming import TrimmingConfig
from bspline_slam.models.protocol import Model
from bspline_slam.observation import across_sigma
from bspline_slam.sights import Feet, KeyObservations, Sights, collect_sights, find_feet
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.merging import MergingConfig, merged
from bspline_slam.tidying.parting import parted

WARY_GAP, WARY_SMEAR = 0.8, 0.6
"""Shares of the limits of the adjustment's trimming, for gaps and for how far beams may lie from their curve, that hold
here: what they let pass stays in the map though its curve has not settled yet."""


def tidied(
    keys: Sequence[KeyObservations],
    poses: Float[np.ndarray, "n 3"],
    splines: SplineMap,
    merging: MergingConfig,
    adjustment: AdjustmentConfig,
    model: Model,
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    """Key scans and map, their splines merged and parted as beams at these poses ask for.

    Curves whose control points say where they were seen along themselves stay as they are.
    """
    if model.measures_along:
        return tuple(keys), splines
    trimming = _warier(adjustment.trimming)
    sights, feet = _seen(keys, splines, poses, adjustment)
    normals = se2.rotate(-poses[sights.pose], feet.normals)
    sigma = across_sigma(normals, sights.directions, sights.ranges, model.fitting)
    keys, splines = merged(keys, splines, sights, feet, sigma, trimming.smear, merging)
    sights, feet = _seen(keys, splines, poses, adjustment)
    keys, splines = parted(keys, splines, sights, feet, trimming, model)
    return keys, counted(keys, splines)


def _warier(config: TrimmingConfig) -> TrimmingConfig:
    """Trimming that takes less for a gap, and for smeared."""
    gap, ratio = WARY_GAP * config.gap, WARY_GAP * config.gap_ratio
    return replace(config, gap=gap, gap_ratio=ratio, smear=WARY_SMEAR * config.smear)


def _seen(
    keys: Sequence[KeyObservations], splines: SplineMap, poses: Float[np.ndarray, "n 3"], config: AdjustmentConfig
) -> tuple[Sights, Feet]:
    """The beams of the associations and their feet, as the first round of the adjustment finds them."""
    sights = collect_sights(keys, splines)
    return sights, find_feet(sights, splines, poses, config.gates[0], config.trimming.reach)


def counted(keys: Sequence[KeyObservations], splines: SplineMap) -> SplineMap:
    """The map with the number of key scans that saw each spline."""
    seen = Counter(spline for key in keys for spline in {association.spline for association in key.associations})
    return SplineMap(tuple(replace(spline, observations=seen[spline.id]) for spline in splines))
