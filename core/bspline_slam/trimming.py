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
    """A stretch of curve is kept where `support` key scans saw every `support_step` of parameter (m) and no gap between
    two beams is wider than `gap` (m) and than `gap_ratio` times how far the beams beside it would lie from their
    neighbours on a wall that faces the robot: what is in a gap is anybody's guess, and no covariance tells of it.
    Splines that are cut to less than `shortest` (m) are dropped. A knot is kept where it lowers χ² by more than
    `idle_gain`: noise alone makes it 1."""

    support: int = 2
    support_step: float = 0.4
    shortest: float = 0.1
    gap: float = 0.1
    gap_ratio: float = 1.5
    idle_gain: float = 1.0


def trimmed(splines: SplineMap, sights: Sights, feet: Feet, config: TrimmingConfig, model: Model) -> SplineMap:
    """Each spline cut back to its longest stretch that `support` key scans saw without a gap, without the control
    points beyond it.

    Where `support` key scans saw none of it, the longest stretch without a gap stays: it is the map's best guess.
    Splines of which hardly anything is left are gone.
    """
    kept = np.flatnonzero(feet.counts)
    apart = facing_spacing(sights, kept)
    cuts = np.searchsorted(sights.spline[kept], np.arange(len(splines) + 1))
    out = []
    for spline, a, b in zip(splines, cuts[:-1], cuts[1:], strict=True):
        mine = kept[a:b]
        span = supported_span(feet.t[mine], sights.pose[mine], apart[a:b], spline.span, config)
        if span == spline.span:
            out.append(spline)
        elif span[1] - span[0] >= config.shortest:
            out.append(replace(spline, curve=model.cut(spline.curve, span), span=span))
    return SplineMap(tuple(out))


def facing_spacing(sights: Sights, kept: Int[np.ndarray, "m"]) -> Float[np.ndarray, "m"]:
    """How far (m) from the nearer of its neighbours in its piece each of these beams would end on a wall that faces the
    robot, 0 where it has none."""
    directions, piece = sights.directions[kept], sights.piece[kept]
    turn = np.abs(directions[:-1, 0] * directions[1:, 1] - directions[:-1, 1] * directions[1:, 0])
    turn = np.where(np.diff(piece) == 0, turn, np.inf)
    nearer = np.minimum(np.append(np.inf, turn), np.append(turn, np.inf))[: len(kept)]
    return np.where(np.isfinite(nearer), nearer, 0.0) * sights.ranges[kept]


def supported_span(
    t: Float[np.ndarray, "m"],
    pose: Int[np.ndarray, "m"],
    apart: Float[np.ndarray, "m"],
    span: tuple[float, float],
    config: TrimmingConfig,
) -> tuple[float, float]:
    """The longest stretch of `span` in which every `support_step` of parameter was seen from `support` poses, and
    without a gap; `apart` is how far each beam lies from its neighbours."""
    low, high = span
    bins = max(round((high - low) / config.support_step), 1)
    width = (high - low) / bins
    place = np.clip(((t - low) / width).astype(np.int64), 0, bins - 1)
    count = int(pose.max(initial=0)) + 1
    seen = np.unique(place * count + pose) // count
    enough = np.bincount(seen, minlength=bins) >= config.support
    edges = np.flatnonzero(np.diff(enough.astype(np.int8), prepend=0, append=0))
    bounds = low + width * (edges if len(edges) else np.array([0, bins]))
    bounds = np.where(bounds > high - 1e-9, high, bounds).reshape(-1, 2).tolist()
    stretches = [one for first, last in bounds for one in _without_gaps(t, apart, (first, last), config)]
    return max(stretches, key=lambda one: one[1] - one[0])


def _without_gaps(
    t: Float[np.ndarray, "m"], apart: Float[np.ndarray, "m"], bounds: tuple[float, float], config: TrimmingConfig
) -> list[tuple[float, float]]:
    """What gaps leave of a stretch; all of it where there is no beam."""
    inside = np.flatnonzero((t >= bounds[0]) & (t <= bounds[1]))
    if len(inside) == 0:
        return [bounds]
    order = inside[np.argsort(t[inside], kind="stable")]
    places = np.concatenate([bounds[:1], t[order], bounds[1:]])
    around = np.concatenate([apart[order[:1]], apart[order], apart[order[-1:]]])
    allowed = np.maximum(config.gap, config.gap_ratio * np.maximum(around[:-1], around[1:]))
    wide = np.flatnonzero(np.diff(places) > allowed)
    starts, ends = np.append(0, wide + 1), np.append(wide, len(places) - 1)
    return list(zip(places[starts].tolist(), places[ends].tolist(), strict=True))


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
