"""The least-squares problem that edits leave: that of the ground, with the factors of what they changed exchanged.

A unit is all that one key scan says of one spline. Units that edits changed are linearised where the map is now, and
so are those that have moved far from where they were; all others keep their factors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.adjustment.spline_graph import build_graph
from bspline_slam.association import Association
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.packing import CurveTerms
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.ground import Ground, middles
from bspline_slam.edits.loop_edits import pins
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import Graph, PoseFactor, ShapePrior, SplineFactor
from bspline_slam.sights import KeyObservations, collect_sights
from bspline_slam.spline_map import SplineMap

Unit = tuple[int, int]
"""The number of a key scan and the id of a spline."""

PINNED = 1e-4
"""Standard deviation (m) of the control points of a pinned spline."""
FAR = 0.01
"""A unit whose pose and spline moved against each other by more than this (m) is linearised anew; along a straight
wall they slide without a word."""


@dataclass(frozen=True, eq=False, slots=True)
class Changes:
    """How decisions differ from those of the ground: the units that are to be linearised, and the splines whose curve
    is not that of the ground's problem."""

    units: frozenset[Unit]
    drawn: frozenset[int]

    @classmethod
    def of(cls, ground: Ground, decisions: Decisions) -> Changes:
        """What edits changed."""
        known = set(ground.estimate.graph.spline_ids.tolist())
        drawn = {s.id for s in decisions.splines if s.id in decisions.reshaped or s.id not in known}
        return cls(frozenset(_changed_units(ground.decisions.keys, decisions.keys)), frozenset(drawn))

    def concern(self, number: int, association: Association) -> bool:
        """Whether a piece of this key scan is to be linearised."""
        spline = association.spline
        return spline is not None and (spline in self.drawn or (number, spline) in self.units)

    def with_units(self, units: Iterable[Unit]) -> Changes:
        """More units to be linearised."""
        return replace(self, units=self.units | set(units))


def _changed_units(before: Sequence[KeyObservations], after: Sequence[KeyObservations]) -> Iterable[Unit]:
    for number, (old, new) in enumerate(zip(before, after, strict=True)):
        if old is new:
            continue
        was, told = _by_spline(old.associations), _by_spline(new.associations)
        for spline in was.keys() | told.keys():
            if was.get(spline) != told.get(spline):
                yield number, spline


def _by_spline(associations: Sequence[Association]) -> dict[int, list[Association]]:
    found: dict[int, list[Association]] = {}
    for association in associations:
        if association.spline is not None:
            found.setdefault(association.spline, []).append(association)
    return found


def linearised(ground: Ground, decisions: Decisions, changes: Changes) -> Graph:
    """The terms of the changed units and drawn splines alone, as a graph without poses of its own: its factors carry
    the numbers of the decisions' poses. Beams that a person gave to a spline have no gate."""
    told = list(_concerned(decisions, changes)) or [(0, replace(decisions.keys[0], associations=()))]
    keys, numbers = [key for _, key in told], [number for number, _ in told]
    named = {a.spline for key in keys for a in key.associations}
    splines = SplineMap(tuple(spline for spline in decisions.splines if spline.id in named))
    sights, place = collect_sights(keys, splines), {spline.id: k for k, spline in enumerate(splines)}
    by_hand = [(place[a.spline], a.by == "hand") for key in keys for a in key.associations if a.spline in place]
    held = np.array([hand for _, hand in sorted(by_hand, key=lambda piece: piece[0])], dtype=bool)
    gates = np.where(held[sights.piece], np.inf, ground.config.adjustment.gates[-1])
    graph = build_graph(
        keys, decisions.poses[numbers], splines, (), sights, ground.config.adjustment, ground.model, gates
    )
    factors = FlatFactors.of(graph.spline_factors)
    return replace(graph, spline_factors=replace(factors, pose=np.array(numbers, dtype=np.int64)[factors.pose]))


def _concerned(decisions: Decisions, changes: Changes) -> Iterator[tuple[int, KeyObservations]]:
    """The key scans of changed units and those that saw drawn splines, with these associations alone."""
    numbers = range(len(decisions.keys)) if changes.drawn else sorted({number for number, _ in changes.units})
    for number in numbers:
        key = decisions.keys[number]
        chosen = tuple(a for a in key.associations if changes.concern(number, a))
        if chosen:
            yield number, replace(key, associations=chosen)


def held_by_hand(decisions: Decisions, changes: Changes) -> bool:
    """Whether beams are held to a spline however far they lie from it: the robust weight of these changes with every
    step, so that they have to be linearised again and again."""
    return any(
        a.by == "hand" and changes.concern(number, a)
        for number, key in enumerate(decisions.keys)
        for a in key.associations
    )


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """A graph, and where the middle control point of each of its spline factors lay, seen from its pose, when that was
    linearised."""

    graph: Graph
    seen: Float[np.ndarray, "f 2"]

    @classmethod
    def of(cls, ground: Ground, decisions: Decisions, changes: Changes, new: Graph) -> Problem:
        """That of the ground with the factors of the changes exchanged for those of `new`, which is linearised where
        the decisions are now."""
        old, drawn = ground.estimate.graph, changes.drawn
        was, told = FlatFactors.of(old.spline_factors), FlatFactors.of(new.spline_factors)
        whose, of_whom = owners(old, was.first), owners(new, told.first)
        stay = ~np.isin(whose, list(drawn)) & ~((was.readings > 0) & whose_units(was.pose, whose, changes.units))
        come = (told.readings > 0) | np.isin(of_whom, list(drawn))
        observed = {*whose[stay & (was.readings > 0)].tolist(), *of_whom[come & (told.readings > 0)].tolist()}
        splines = [spline for spline in decisions.splines if spline.id in observed]
        offsets = np.cumsum([0, *(len(spline.curve.control_points) for spline in splines)]).astype(np.int64)
        places = {spline.id: offset for spline, offset in zip(splines, offsets.tolist(), strict=False)}
        stay &= np.isin(whose, list(places))
        come &= np.isin(of_whom, list(places))
        bends = [
            *(term for term in on_splines(old, bends_of(ground)) if term[0] not in drawn),
            *(term for term in on_splines(new, new.shape_priors) if term[0] in drawn),
        ]
        factors = FlatFactors.joined([moved_to(old, was, stay, places), moved_to(new, told, come, places)])
        graph = Graph(
            key_scans=old.key_scans,
            poses=decisions.poses,
            spline_ids=np.array([spline.id for spline in splines], dtype=np.int64),
            spline_first=offsets,
            control_points=np.concatenate([np.zeros((0, 2)), *(spline.curve.control_points for spline in splines)]),
            spline_factors=factors.compact(),
            pose_factors=pose_factors(ground, decisions),
            pose_priors=(old.pose_priors[0], *pins(decisions, ground.config.adjustment.anchor)),
            shape_priors=(*placed(bends, places), *pinned(decisions, places)),
        )
        here = middles(told.chosen(come), decisions.poses, new.control_points)
        return cls(graph, np.concatenate([ground.seen[stay], here]))

    def moved_units(self, curves: CurveTerms, state: State) -> set[Unit]:
        """The units whose pose and spline have moved far against each other, in the direction that the unit tells most
        of, since they were linearised; `curves` are the terms of the graph."""
        factors = FlatFactors.of(self.graph.spline_factors)
        count, middle = 2 * factors.size[:, 1], 2 * (factors.size[:, 1] // 2)
        at = curves.start[: len(factors), 2] + middle * (count + 1)
        xx, xy, yy = curves.gram[at], curves.gram[at + 1], curves.gram[at + count + 1]
        x, y = (middles(factors, state.poses, state.control_points) - self.seen).T
        most = 0.5 * (xx + yy + np.hypot(xx - yy, 2.0 * xy))
        far = (factors.readings > 0) & (xx * x * x + 2.0 * xy * x * y + yy * y * y > FAR**2 * most)
        return set(zip(factors.pose[far].tolist(), owners(self.graph, factors.first[far]).tolist(), strict=True))


def bends_of(ground: Ground) -> Sequence[ShapePrior]:
    """The shape priors of the ground's problem without those that hold pinned splines, which come last."""
    priors = ground.estimate.graph.shape_priors
    held = np.isin(ground.estimate.graph.spline_ids, list(ground.decisions.spline_pins)).sum()
    return priors[: len(priors) - int(held)]


def owners(graph: Graph, first: Int[np.ndarray, "f"]) -> Int[np.ndarray, "f"]:
    """The ids of the splines that terms are about, from the first control point of each."""
    return graph.spline_ids[np.searchsorted(graph.spline_first, first, side="right") - 1]


def whose_units(
    poses: Int[np.ndarray, "f"], splines: Int[np.ndarray, "f"], units: frozenset[Unit]
) -> Bool[np.ndarray, "f"]:
    """Which factors, by pose and spline, are of one of the units."""
    named = np.array(sorted(units), dtype=np.int64).reshape(-1, 2)
    return np.isin(poses << 32 | splines, named[:, 0] << 32 | named[:, 1])


def moved_to(
    graph: Graph, factors: FlatFactors, which: Bool[np.ndarray, "f"], places: Mapping[int, int]
) -> FlatFactors:
    """Those factors of a graph, on the control points of another one, where `places` tell where each spline begins."""
    kept = factors.chosen(which)
    by = {spline: places[spline] - first for spline, first in _begins(graph) if spline in places}
    moves = np.array([by[spline] for spline in owners(graph, kept.first).tolist()], dtype=np.int64)
    return replace(kept, first=kept.first + moves)


def _begins(graph: Graph) -> Iterator[tuple[int, int]]:
    """Each spline of a graph with its first control point."""
    return zip(graph.spline_ids.tolist(), graph.spline_first.tolist(), strict=False)


OnSpline = TypeVar("OnSpline", SplineFactor, ShapePrior)


def on_splines(graph: Graph, terms: Sequence[OnSpline]) -> Iterator[tuple[int, int, OnSpline]]:
    """Each term with the id of its spline and the first control point there that it is about."""
    terms = tuple(terms)
    first = np.array([term.first for term in terms], dtype=np.int64)
    owner = np.searchsorted(graph.spline_first, first, side="right") - 1
    ids, local = graph.spline_ids[owner], first - graph.spline_first[owner]
    yield from zip(ids.tolist(), local.tolist(), terms, strict=True)


def placed(terms: Iterable[tuple[int, int, OnSpline]], places: Mapping[int, int]) -> Iterator[OnSpline]:
    """The terms on the control points of another graph; those of splines that are not in it are left out."""
    for spline, local, term in terms:
        if spline in places:
            first = places[spline] + local
            yield term if term.first == first else replace(term, first=first)


def pose_factors(ground: Ground, decisions: Decisions) -> tuple[PoseFactor, ...]:
    """Those of the ground's problem that are still believed, and the new ones as they are."""
    weighted = {
        id(factor): weighted
        for factor, weighted in zip(ground.decisions.factors, ground.estimate.graph.pose_factors, strict=True)
    }
    return tuple(weighted.get(id(factor), factor) for factor in decisions.factors)


def pinned(decisions: Decisions, places: Mapping[int, int]) -> Iterator[ShapePrior]:
    """What holds pinned splines."""
    for spline in sorted(decisions.spline_pins.keys() & places.keys()):
        points = decisions.spline_pins[spline]
        yield ShapePrior(places[spline], np.eye(points.size) / PINNED, points.ravel() / PINNED)
