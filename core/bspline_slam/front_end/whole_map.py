"""A search through a whole map: the last key scans, taken together, are looked for by branch and bound over ever
smaller squares (Hess et al. 2016). A place counts only if no other one is nearly as good."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closure import LoopConfig, Proposal, proposal_of
from bspline_slam.front_end.scan_matching import MatchingConfig, find_with_icp, gather, likelihood_field
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.kernels import anywhere


@dataclass(frozen=True, slots=True)
class PlaceConfig:
    """How a place is looked for (m, rad).

    `together` key scans are looked for as one, with beams no longer than `reach`, at most `points` of them, evenly of
    surfaces that face one of so many `facings` (0: all are alike), at `turns` headings in a whole turn, on a field of
    cells of size `cell`, or larger ones where the map would have more than `most_cells`. A place needs a correlation of
    `least_score`, and no other one, `apart` or `apart_turn` from it, may come within `margin` of it, or, where that is
    less, within what it falls short of 1, but at least `least_margin`.
    Two key scans must agree within `agree_distance` and `agree_turn`.
    """

    together: int = 6
    reach: float = 20.0
    points: int = 120
    facings: int = 0
    cell: float = 0.1
    most_cells: float = 2e6
    levels: int = 7
    turns: int = 480
    least_score: float = 0.6
    margin: float = 0.1
    least_margin: float = 0.1
    apart: float = 1.0
    apart_turn: float = np.deg2rad(10.0)
    agree_distance: float = 0.3
    agree_turn: float = np.deg2rad(3.0)


@dataclass(frozen=True, eq=False, slots=True)
class Window:
    """Poses that come into question: at most `reach` (m) and `turn` (rad) from `middle`."""

    middle: Float[np.ndarray, "3"]
    reach: float
    turn: float


EVERYWHERE = Window(np.zeros(3), np.inf, np.pi)


@dataclass(frozen=True, eq=False, slots=True)
class WholeMap:
    """The pyramid of the likelihood field of key scans, its first corner (m) and the size of its cells (m)."""

    bounds: Float[np.ndarray, "levels rows columns"]
    origin: Float[np.ndarray, "2"]
    cell: float

    @classmethod
    def of(
        cls,
        keys: Sequence[KeyScan],
        poses: Float[np.ndarray, "n 3"],
        known: Sequence[int] | Int[np.ndarray, "k"],
        config: PlaceConfig,
        matching: MatchingConfig,
    ) -> WholeMap:
        """What these key scans (by number) saw."""
        old = gather([keys[k].points for k in known], poses[known])
        cell = max(config.cell, float(np.sqrt(np.prod(np.ptp(old.points, axis=0)) / config.most_cells)))
        coarse = likelihood_field(old, replace(matching, cell=cell, field_sigma=cell), 1)
        return cls(anywhere.pyramid(coarse.values, config.levels), coarse.origin, cell)

    def only_place(
        self, points: Float[np.ndarray, "m 2"], config: PlaceConfig, window: Window = EVERYWHERE
    ) -> Float[np.ndarray, "3"] | None:
        """The only pose of a window at which points (robot frame) fit; None where there is none or several."""
        if len(points) == 0:
            return None
        half = int(np.ceil(window.turn * config.turns / (2.0 * np.pi) - 1e-9))
        headings = window.middle[2] + window.turn * np.arange(-half, half + 1) / max(half, 1)
        args = (self.bounds, self.origin, self.cell, points, headings, window.middle, window.reach)
        *pose, score = anywhere.search_anywhere(*args, config.least_score, np.zeros(3), -1.0, -1.0)
        if score <= config.least_score:
            return None
        found, least = np.array(pose), score - float(np.clip(1.0 - score, config.least_margin, config.margin))
        *_, second = anywhere.search_anywhere(*args, least, found, config.apart, config.apart_turn)
        return None if second > least else found


def last_points(
    keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], first: int, config: PlaceConfig
) -> Float[np.ndarray, "m 2"]:
    """Beam ends of the key scans from number `first` on in the frame of the last one, no two near each other.

    Where `facings` are told apart, there are as many of surfaces that face one way as of those that face another
    (normal-space sampling, Rusinkiewicz and Levoy 2001): along a corridor the little that is not its walls tells where.
    """
    steps = [se2.between(poses[-1], poses[k]) for k in range(first, len(keys))]
    sets = [keys[k].points for k in range(first, len(keys))]
    points = np.concatenate([se2.transform(step, one.points) for step, one in zip(steps, sets, strict=True)])
    normals = np.concatenate([se2.rotate(step, one.normals) for step, one in zip(steps, sets, strict=True)])
    near = np.hypot(*points.T) < config.reach
    _, kept = np.unique(np.floor(points[near] / config.cell).astype(np.int64), axis=0, return_index=True)
    kept = np.flatnonzero(near)[np.sort(kept)]
    if config.facings == 0:
        return points[kept[:: max(len(kept) // config.points, 1)]]
    return points[kept[evenly(facing(normals[kept], config.facings), config.points)]]


def facing(normals: Float[np.ndarray, "m 2"], ways: int) -> Int[np.ndarray, "m"]:
    """Which of so many ways, or none of them (−1), each surface runs."""
    way = np.floor(np.arctan2(normals[:, 1], normals[:, 0]) * ways / np.pi + 0.5).astype(np.int64) % ways
    return np.where(np.any(normals, axis=1), way, -1)


def evenly(kinds: Int[np.ndarray, "m"], most: int) -> Int[np.ndarray, "_"]:
    """Which to keep, about `most` in all, so that no kind has more than another that had enough; in their order."""
    values, counts = np.unique(kinds, return_counts=True)
    share = next((c for c in range(most, 0, -1) if np.minimum(counts, c).sum() <= most), 1)
    kept = np.zeros(len(kinds), dtype=bool)
    for value, count in zip(values, counts, strict=True):
        kept[np.flatnonzero(kinds == value)[np.linspace(0, count - 1, min(count, share)).astype(np.int64)]] = True
    return np.flatnonzero(kept)


def proposal_at(
    found: Float[np.ndarray, "3"],
    keys: Sequence[KeyScan],
    poses: Float[np.ndarray, "n 3"],
    known: Sequence[int] | Int[np.ndarray, "k"],
    loops: LoopConfig,
    matching: MatchingConfig,
    tracking: TrackingConfig,
    preface: str,
) -> Proposal:
    """The last key scan matched at the place found to the surroundings of the nearest of the `known` key scans."""
    known = np.asarray(known)
    away = np.hypot(*(poses[known, :2] - found[:2]).T)
    i = int(known[np.argmin(away + 0.5 * np.abs(se2.wrap(poses[known, 2] - found[2])))])
    near = known[np.argsort(away)[: 2 * loops.half_width + 1]]
    places, scan = [keys[k].points for k in near], keys[-1].points
    match = find_with_icp(places, poses[near], scan, found, matching, 0.3, np.deg2rad(3.0))
    return proposal_of(match, keys, poses, i, loops, tracking, preface)


def agree(before: Proposal, now: Proposal, poses: Float[np.ndarray, "n 3"], config: PlaceConfig) -> bool:
    """Whether both put the later key scan at the same place, by the way from one to the other."""
    first = se2.compose(poses[before.i], before.closure.measured)
    expected = se2.compose(first, se2.between(poses[before.j], poses[now.j]))
    off = se2.between(expected, se2.compose(poses[now.i], now.closure.measured))
    return bool(np.hypot(off[0], off[1]) < config.agree_distance and abs(off[2]) < config.agree_turn)
