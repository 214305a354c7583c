"""Splines cut back to what is seen often enough, and freed of the knots that no beam asks for."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.adjustment.knots import without_idle_knots
from bspline_slam.fitting import FittingConfig
from bspline_slam.kernels import support as kernels
from bspline_slam.models.protocol import Model
from bspline_slam.observation import across_sigma
from bspline_slam.sights import Feet, Sights
from bspline_slam.spline_map import MapSpline, SplineMap

NEARBY = 2
"""Support is counted in so many cells of parameter to either side."""


@dataclass(frozen=True, slots=True)
class TrimmingConfig:
    """A stretch of curve is kept where `support` key scans saw it, not more than `support_reach` (m) away, and no gap
    between two beams is wider than `gap` (m) and than `gap_ratio` times how far the beams beside it would lie from
    their neighbours on a wall that faces the robot: what is in a gap is anybody's guess, and no covariance tells of it.
    It ends where its last beam does, up to `reach` (m) beyond where it ended before. Splines that are cut to less than
    `shortest` (m) are dropped, and so are those from which beams lie more than `smear` times as far as their noise
    would have it. A knot is kept where it lowers χ² by more than `idle_gain`: noise alone makes it 1 on the average,
    and more than 8 for one knot in 200."""

    support: int = 2
    support_reach: float = 0.2
    reach: float = 0.05
    shortest: float = 0.1
    gap: float = 0.1
    gap_ratio: float = 1.5
    idle_gain: float = 8.0
    smear: float = 2.5


def trimmed(splines: SplineMap, sights: Sights, feet: Feet, config: TrimmingConfig, model: Model) -> SplineMap:
    """Each spline on the longest of its stretches that `support` key scans saw without a gap, without the control
    points beyond it.

    Where `support` key scans saw none of it, the longest stretch without a gap stays: it is the map's best guess.
    Splines of which hardly anything is left are gone.
    """
    out = []
    for spline, stretches in zip(splines, seen_stretches(splines, sights, feet, config), strict=True):
        span = max(stretches, key=lambda one: one[1] - one[0], default=spline.span)
        if span == spline.span:
            out.append(spline)
        elif span[1] - span[0] >= config.shortest:
            out.append(on_stretch(spline, span, model))
    return SplineMap(tuple(out))


def on_stretch(spline: MapSpline, span: tuple[float, float], model: Model) -> MapSpline:
    """The spline on a stretch alone, which may lie a little beyond the present one."""
    return replace(spline, curve=model.cut(spline.curve.reaching(span), span), span=span)


def seen_stretches(
    splines: SplineMap, sights: Sights, feet: Feet, config: TrimmingConfig
) -> Iterator[list[tuple[float, float]]]:
    """Of each spline the stretches (from one parameter to another, in order) that were seen often enough, without a
    gap; none where no beam counts."""
    kept = np.flatnonzero(feet.counts)
    apart = facing_spacing(sights, kept)
    cuts = np.searchsorted(sights.spline[kept], np.arange(len(splines) + 1))
    for a, b in itertools.pairwise(cuts.tolist()):
        mine = kept[a:b]
        yield supported_stretches(feet.t[mine], sights.pose[mine], apart[a:b], config)


def facing_spacing(sights: Sights, kept: Int[np.ndarray, "m"]) -> Float[np.ndarray, "m"]:
    """How far (m) from the nearer of its neighbours in its piece each of these beams would end on a wall that faces the
    robot, 0 where it has none."""
    directions, piece = sights.directions[kept], sights.piece[kept]
    turn = np.abs(directions[:-1, 0] * directions[1:, 1] - directions[:-1, 1] * directions[1:, 0])
    turn = np.where(np.diff(piece) == 0, turn, np.inf)
    nearer = np.minimum(np.append(np.inf, turn), np.append(turn, np.inf))[: len(kept)]
    return np.where(np.isfinite(nearer), nearer, 0.0) * sights.ranges[kept]


def supported_stretches(
    t: Float[np.ndarray, "m"], pose: Int[np.ndarray, "m"], apart: Float[np.ndarray, "m"], config: TrimmingConfig
) -> list[tuple[float, float]]:
    """The stretches, from beam to beam, that were seen from `support` poses and have no gap, in order; `apart` is how
    far each beam lies from its neighbours."""
    if len(t) == 0:
        return []
    order = np.argsort(t, kind="stable")
    supported = order[_support(t[order], pose[order], config.support_reach) >= config.support]
    chosen = supported if len(supported) else order
    places, around = t[chosen], apart[chosen]
    allowed = np.maximum(config.gap, config.gap_ratio * np.maximum(around[:-1], around[1:]))
    wide = np.flatnonzero(np.diff(places) > allowed)
    starts, ends = np.append(0, wide + 1), np.append(wide, len(places) - 1)
    return list(zip(places[starts].tolist(), places[ends].tolist(), strict=True))


def _support(t: Float[np.ndarray, "m"], pose: Int[np.ndarray, "m"], reach: float) -> Int[np.ndarray, "m"]:
    """From how many poses each of these places (in order) was seen, or what lies within about `reach` of it."""
    return kernels.support(((t - t[0]) / (reach / NEARBY)).astype(np.int64), pose, NEARBY)


def agreed(
    splines: SplineMap,
    sights: Sights,
    feet: Feet,
    poses: Float[np.ndarray, "n 3"],
    config: TrimmingConfig,
    fitting: FittingConfig,
) -> SplineMap:
    """The splines whose beams agree where they are; legs of chairs and of people, and what else no curve describes,
    are not of the map."""
    kept, sigma = _counted(sights, feet, poses, fitting)
    across = feet.across[kept] / sigma
    owner, count = sights.spline[kept], len(splines)
    spread = np.bincount(owner, across**2, count) / np.maximum(np.bincount(owner, minlength=count), 1)
    return SplineMap(tuple(splines.splines[k] for k in np.flatnonzero(spread <= config.smear**2)))


def _counted(
    sights: Sights, feet: Feet, poses: Float[np.ndarray, "n 3"], fitting: FittingConfig
) -> tuple[Int[np.ndarray, "k"], Float[np.ndarray, "k"]]:
    """The beams that count, and the standard deviation of their ends across their curves (m)."""
    kept = np.flatnonzero(feet.counts)
    seen = se2.rotate(-poses[sights.pose[kept]], feet.normals[kept])
    return kept, across_sigma(seen, sights.directions[kept], sights.ranges[kept], fitting)


def thinned(
    splines: SplineMap,
    sights: Sights,
    feet: Feet,
    poses: Float[np.ndarray, "n 3"],
    config: TrimmingConfig,
    fitting: FittingConfig,
) -> SplineMap:
    """Each spline without the knots that its beams do not ask for."""
    kept, sigma = _counted(sights, feet, poses, fitting)
    normals, weight = feet.normals[kept], 1.0 / sigma
    cuts = np.searchsorted(sights.spline[kept], np.arange(len(splines) + 1))
    out = []
    for spline, a, b in zip(splines, cuts[:-1], cuts[1:], strict=True):
        plain = without_idle_knots(spline.curve, feet.t[kept[a:b]], normals[a:b], weight[a:b], config.idle_gain)
        out.append(replace(spline, curve=plain.curve, left_out=spline.left_out + plain.left_out))
    return SplineMap(tuple(out))
