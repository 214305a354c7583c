"""Curves parted where beams leave a gap: what a gap cuts off is a spline of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.adjustment.trimming import TrimmingConfig, on_stretch, seen_stretches
from bspline_slam.models.protocol import Model
from bspline_slam.sights import Feet, KeyObservations, Sights
from bspline_slam.spline_map import MapSpline, SplineMap
from bspline_slam.tidying.handing_over import handed_over


def parted(
    keys: Sequence[KeyObservations],
    splines: SplineMap,
    sights: Sights,
    feet: Feet,
    config: TrimmingConfig,
    model: Model,
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    """Each spline cut to the stretches that were seen often enough, without a gap; the longest keeps the id.

    Splines of which no stretch is long enough are gone. Beams go to the stretch nearest to their foot.
    """
    fresh = _next_id(keys, splines)
    cuts = np.searchsorted(sights.spline, np.arange(len(splines) + 1))
    owners = np.array([spline.id for spline in splines], dtype=np.int64)[sights.spline]
    parts: list[MapSpline] = []
    for k, stretches in enumerate(seen_stretches(splines, sights, feet, config)):
        whole, mine = splines.splines[k], slice(int(cuts[k]), int(cuts[k + 1]))
        spans = [one for one in stretches if one[1] - one[0] >= config.shortest]
        spans.sort(key=lambda one: one[0] - one[1])
        ids = np.array([whole.id, *range(fresh, fresh + len(spans) - 1)], dtype=np.int64)
        fresh += max(len(spans) - 1, 0)
        if len(spans) > 1:
            owners[mine] = ids[_nearest(feet.t[mine], spans)]
        parts.extend(_part(whole, number, span, model) for number, span in zip(ids.tolist(), spans, strict=False))
    handed = handed_over(keys, splines, sights, owners, feet.across)
    return handed, SplineMap(tuple(sorted(parts, key=lambda one: one.id)))


def _part(whole: MapSpline, number: int, span: tuple[float, float], model: Model) -> MapSpline:
    """A stretch of a spline, under a number."""
    part = on_stretch(whole, span, model)
    if number == whole.id:
        return part
    return replace(part, id=number, history=(*whole.history, f"parted from spline {whole.id} at a gap"))


def _nearest(t: Float[np.ndarray, "m"], spans: Sequence[tuple[float, float]]) -> Int[np.ndarray, "m"]:
    """Which of the stretches lies nearest to each parameter."""
    low, high = np.array(spans).T
    return np.argmin(np.maximum(np.maximum(low - t[:, None], t[:, None] - high), 0.0), axis=1)


def _next_id(keys: Sequence[KeyObservations], splines: SplineMap) -> int:
    """An id that no spline has and no association names, nor any above it."""
    named = (a.spline for key in keys for a in key.associations if a.spline is not None)
    return max((*named, *(spline.id for spline in splines)), default=-1) + 1
