"""Splines that show one wall twice: where they run side by side, the beams of the weaker go to the stronger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.curve_samples import CurveSamples
from bspline_slam.sights import Feet, KeyObservations, Sights
from bspline_slam.spline_map import MapSpline, SplineMap
from bspline_slam.tidying.alongside import Alongside, alongside
from bspline_slam.tidying.handing_over import handed_over, renamed

SPACING = 0.05
"""Distance (m) between the samples at which curves are held against each other."""
LEAST_RUN = 3
"""Fewer samples than these in a row are no stretch of their own."""
NONE = -1


@dataclass(frozen=True, slots=True)
class MergingConfig:
    """Curves are one wall where a single one would do for the beams of both, and where beams put them no farther than
    `same` apart (m, root mean square), or no farther than `double` if hardly any scan saw both, as it would two
    surfaces: at most the share `together` of those that saw the one that fewer saw."""

    same: float = 0.03
    double: float = 0.05
    together: float = 0.1


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """What beams saw of the curves of a map.

    `samples` lie where beams put the curves, which are not fitted to them yet: each `off` (m) in front of its curve.
    `cell` is the sample near the foot of each beam. Of the beams of each sample that count: Σ 1/σ² (`weight`, 1/m²),
    and Σ r/σ² (`first`) and Σ r²/σ² (`second`) of their distances r from the sample, across the curve.
    """

    samples: CurveSamples
    cell: Int[np.ndarray, "m"]
    off: Float[np.ndarray, "s"]
    weight: Float[np.ndarray, "s"]
    first: Float[np.ndarray, "s"]
    second: Float[np.ndarray, "s"]

    @classmethod
    def of(cls, splines: SplineMap, sights: Sights, feet: Feet, sigma: Float[np.ndarray, "m"]) -> Seen:
        """By beams with these standard deviations across the curves (m)."""
        samples = CurveSamples.of(splines.splines, SPACING)
        cell, count = samples.near(sights.spline, feet.t), len(samples.t)
        mine, across, information = cell[feet.counts], feet.across[feet.counts], sigma[feet.counts] ** -2.0
        off = np.bincount(mine, across, count) / np.maximum(np.bincount(mine, minlength=count), 1)
        r = across - off[mine]
        sums = (np.bincount(mine, information * r**power, count) for power in range(3))
        samples = replace(samples, points=samples.points + off[:, None] * samples.normals)
        return cls(samples, cell, off, *sums)


def merged(
    keys: Sequence[KeyObservations],
    splines: SplineMap,
    sights: Sights,
    feet: Feet,
    sigma: Float[np.ndarray, "m"],
    smear: float,
    config: MergingConfig,
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    """Each wall one curve, that which most beams saw, with the beams of all; the oldest id lives on.

    What of a weaker curve does not run beside a stronger one stays as it is. `sigma` is the standard deviation of each
    beam across its curve (m), up to a factor that beams tell; a curve from which they lie more than `smear` times as
    far does for none.
    """
    if len(splines) == 0:
        return tuple(keys), splines
    seen, rank = Seen.of(splines, sights, feet, sigma), _rank(sights, feet, len(splines))
    samples, cell = seen.samples, seen.cell
    found = alongside(samples, config.double)
    found = found.part(rank[samples.owner[found.sample]] < rank[samples.owner[found.beside]])
    found = found.part(_one_wall(found, seen, sights, feet, smear, config))
    heir, apart = _heirs(found, samples, rank)
    ids = np.array([spline.id for spline in splines], dtype=np.int64)
    owners = ids[np.where(heir[cell] == NONE, sights.spline, heir[cell])]
    handed = handed_over(keys, splines, sights, owners, feet.across - seen.off[cell] + apart[cell])
    return _under_oldest_ids(handed, splines, samples, rank, heir)


def _rank(sights: Sights, feet: Feet, count: int) -> Int[np.ndarray, "k"]:
    """The rank of each curve by the number of beams that saw it; of equal ones the older is the stronger."""
    beams = np.bincount(sights.spline[feet.counts], minlength=count)
    rank = np.empty(count, dtype=np.int64)
    rank[np.lexsort((-np.arange(count), beams))] = np.arange(count)
    return rank


def _one_wall(
    found: Alongside, seen: Seen, sights: Sights, feet: Feet, smear: float, config: MergingConfig
) -> Bool[np.ndarray, "p"]:
    """Whether the two curves of each pair are one wall, as far as they run side by side."""
    samples, sample, beside, across = seen.samples, found.sample, found.beside, found.across
    curves = samples.owner[sample] * len(samples.first) + samples.owner[beside]
    _, pair, size = np.unique(curves, return_inverse=True, return_counts=True)
    apart = np.sqrt(np.bincount(pair, across**2) / size)
    squares = seen.second[sample] + 2.0 * across * seen.first[sample] + across**2 * seen.weight[sample]
    count = np.bincount(seen.cell[feet.counts], minlength=len(samples.t))
    spread = np.bincount(pair, squares + seen.second[beside])
    noise = np.median(seen.second[count > 0] / count[count > 0]) if count.any() else 0.0
    agree = spread <= smear**2 * noise * np.bincount(pair, count[sample] + count[beside])
    for k in np.flatnonzero(agree & (apart > config.same)).tolist():
        one, other = (
            np.unique(sights.pose[feet.counts & np.isin(seen.cell, each[pair == k])]) for each in (sample, beside)
        )
        agree[k] = len(np.intersect1d(one, other)) <= config.together * min(len(one), len(other))
    return agree[pair]


def _heirs(
    found: Alongside, samples: CurveSamples, rank: Int[np.ndarray, "k"]
) -> tuple[Int[np.ndarray, "s"], Float[np.ndarray, "s"]]:
    """To which curve each sample goes: the strongest beside it, or none; and how far (m) it lies from that."""
    heir, apart = np.full(len(samples.t), NONE), np.zeros(len(samples.t))
    order = np.argsort(rank[samples.owner[found.beside]], kind="stable")
    heir[found.sample[order]] = samples.owner[found.beside[order]]
    apart[found.sample[order]] = found.across[order]
    for curve in np.unique(samples.owner[found.sample]).tolist():
        mine = slice(int(samples.first[curve]), int(samples.first[curve + 1]))
        heir[mine] = steadied(heir[mine], LEAST_RUN)
    return heir, apart


def steadied(values: Int[np.ndarray, "s"], least: int) -> Int[np.ndarray, "s"]:
    """The values, each run of fewer than `least` equal ones given to the longer of the runs beside it, the shortest
    first."""
    while True:
        edges = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1, [len(values)]])
        lengths = np.diff(edges)
        shortest = int(np.argmin(lengths))
        if len(lengths) == 1 or lengths[shortest] >= least:
            return values
        beside = [k for k in (shortest - 1, shortest + 1) if 0 <= k < len(lengths)]
        longer = max(beside, key=lambda k: lengths[k])
        values = values.copy()
        values[edges[shortest] : edges[shortest + 1]] = values[edges[longer]]


def _under_oldest_ids(
    keys: Sequence[KeyObservations],
    splines: SplineMap,
    samples: CurveSamples,
    rank: Int[np.ndarray, "k"],
    heir: Int[np.ndarray, "s"],
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    """The map without the curves that went to others as a whole; each of these has the oldest id of all that went to
    it."""
    kept = dict(enumerate(splines))
    left = {weak: heir[samples.first[weak] : samples.first[weak + 1]] for weak in np.argsort(rank).tolist()}
    for weak, to in left.items():
        if np.all(to != NONE):
            strong = int(np.bincount(to).argmax())
            kept[strong] = _taken_over(kept[strong], kept.pop(weak))
    for weak, to in left.items():
        if weak in kept and np.any(to != NONE):
            strong = kept[_living(int(np.bincount(to[to != NONE]).argmax()), left)]
            told = f"left {samples.spacing * np.count_nonzero(to != NONE):.1f} m to spline {strong.id}: the same wall"
            kept[weak] = replace(kept[weak], history=(*kept[weak].history, told))
    names = {splines.splines[k].id: spline.id for k, spline in kept.items() if splines.splines[k].id != spline.id}
    return renamed(keys, names), SplineMap(tuple(sorted(kept.values(), key=lambda one: one.id)))


def _living(place: int, left: Mapping[int, Int[np.ndarray, "_"]]) -> int:
    """The curve that took over this one as a whole, if one did, and so on."""
    while np.all(left[place] != NONE):
        place = int(np.bincount(left[place]).argmax())
    return place


def _taken_over(strong: MapSpline, weak: MapSpline) -> MapSpline:
    """A spline that goes on for another, too."""
    older, younger = (strong, weak) if strong.id < weak.id else (weak, strong)
    history = (*strong.history, f"merged with spline {younger.id}, which showed the same wall")
    return replace(strong, id=older.id, born=min(strong.born, weak.born), history=history)
