"""Splines cut back to what is seen often enough, and freed of the knots that no beam asks for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.fitting import FittingConfig
from bspline_slam.knots import without_idle_knots
from bspline_slam.models.protocol import Model
from bspline_slam.observation import across_sigma
from bspline_slam.sights import Feet, Sights
from bspline_slam.spline_map import SplineMap


@dataclass(frozen=True, slots=True)
class TrimmingConfig:
    """A stretch of curve is kept where `support` key scans saw every `support_step` of parameter (m), a knot where it
    lowers χ² by more than `idle_gain`: noise alone makes it 1."""

    support: int = 2
    support_step: float = 0.4
    idle_gain: float = 1.0


def trimmed(splines: SplineMap, sights: Sights, feet: Feet, config: TrimmingConfig, model: Model) -> SplineMap:
    """Each spline cut back to its longest stretch that `support` key scans saw, without the control points beyond it.

    A spline without such a stretch stays as it is: it is the map's best guess.
    """
    kept = np.flatnonzero(feet.counts)
    cuts = np.searchsorted(sights.spline[kept], np.arange(len(splines) + 1))
    out = []
    for k, spline in enumerate(splines):
        mine = kept[cuts[k] : cuts[k + 1]]
        span = supported_span(feet.t[mine], sights.pose[mine], spline.span, config)
        out.append(spline if span == spline.span else replace(spline, curve=model.cut(spline.curve, span), span=span))
    return SplineMap(tuple(out))


def supported_span(
    t: Float[np.ndarray, "m"], pose: Int[np.ndarray, "m"], span: tuple[float, float], config: TrimmingConfig
) -> tuple[float, float]:
    """The longest stretch of `span` in which every `support_step` of parameter was seen from `support` poses."""
    low, high = span
    bins = max(round((high - low) / config.support_step), 1)
    width = (high - low) / bins
    place = np.clip(((t - low) / width).astype(np.int64), 0, bins - 1)
    count = int(pose.max(initial=0)) + 1
    seen = np.unique(place * count + pose) // count
    enough = np.bincount(seen, minlength=bins) >= config.support
    edges = np.flatnonzero(np.diff(enough.astype(np.int8), prepend=0, append=0))
    if len(edges) == 0:
        return span
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    if starts[longest] == 0 and ends[longest] == bins:
        return span
    return low + width * float(starts[longest]), low + width * float(ends[longest])


def thinned(
    splines: SplineMap,
    sights: Sights,
    feet: Feet,
    poses: Float[np.ndarray, "n 3"],
    config: TrimmingConfig,
    fitting: FittingConfig,
) -> SplineMap:
    """Each spline without the knots that its beams do not ask for."""
    kept = np.flatnonzero(feet.counts)
    normals = feet.normals[kept]
    seen = se2.rotate(-poses[sights.pose[kept]], normals)
    weight = 1.0 / across_sigma(seen, sights.directions[kept], sights.ranges[kept], fitting)
    cuts = np.searchsorted(sights.spline[kept], np.arange(len(splines) + 1))
    out = []
    for spline, a, b in zip(splines, cuts[:-1], cuts[1:], strict=True):
        curve = without_idle_knots(spline.curve, feet.t[kept[a:b]], normals[a:b], weight[a:b], config.idle_gain)
        out.append(replace(spline, curve=curve))
    return SplineMap(tuple(out))
