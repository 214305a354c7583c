"""Decisions worth a second look: those that were close, and of these first the ones on which much hangs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.edits.edit import DropLoop, Edit, Forbid, Force, OnPiece
from bspline_slam.edits.exchange import robust_weight
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.slam import SlamConfig, Snapshot

MOST = 200
"""The queue is no longer than this."""
DOUBTFUL = 0.5
"""Decisions with a lower score are not in the queue."""
BESIDE = 0.5
"""A runner-up that explains a smaller share of a piece than this is none."""
LONG = 12
"""A piece of fewer beams than this moves little."""
FEW = 6
"""A spline seen by fewer key scans than this hangs on each of them."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """A doubtful decision about a piece of key scan `scan`, or about the loop closure `closure` of this number.

    `score` is from 0 to 1, 1 for a coin toss on which much hangs; `overrule` are the edits that decide otherwise.
    """

    score: float
    sentence: str
    scan: int
    piece: OnPiece | None = None
    closure: int | None = None
    overrule: tuple[Edit, ...] = ()

    @property
    def subject(self) -> tuple[object, ...]:
        """What it is about, whatever its score."""
        return self.scan, self.piece, self.closure


def doubts(snapshot: Snapshot, config: SlamConfig) -> tuple[Doubt, ...]:
    """The most doubtful decisions behind a map, the worst first; of those by hand only what lies beyond the gate."""
    ids = {spline.id for spline in snapshot.map}
    seen = Counter(s for key in snapshot.observations for s in {a.spline for a in key.associations})
    found = [
        replace(doubt, score=doubt.score * _leverage(association, seen))
        for key in snapshot.observations
        for association in key.associations
        if association.by == "rule" and (doubt := _of_piece(association, ids)) is not None
    ]
    by_hand = (a for key in snapshot.observations for a in key.associations if a.by == "hand")
    found += [doubt for association in by_hand if (doubt := _of_hand(association, ids)) is not None]
    found += _of_closures(snapshot, config)
    worst = sorted((doubt for doubt in found if doubt.score >= DOUBTFUL), key=lambda d: (-d.score, d.scan))
    return tuple(worst[:MOST])


def _leverage(association: Association, seen: Counter[int | None]) -> float:
    """How much hangs on one piece: less where it is short, and where many key scans saw the same spline."""
    count = seen[association.spline] if association.spline is not None else FEW
    beams = association.last - association.first + 1
    shared = 1.0 if count <= FEW else 0.6 + 0.4 * float(np.sqrt(FEW / count))
    return shared * min(beams / LONG, 1.0)


def _of_piece(association: Association, ids: set[int]) -> Doubt | None:
    """The doubt about a piece: a match near the gate, one hardly better than the runner-up, or one just gated out; None
    where it is too small for the queue."""
    where = (association.scan, association.segment, association.first, association.last)
    second = next((c for c in association.candidates if c.spline != association.spline and c.spline in ids), None)
    spline = association.spline
    if association.verdict is Verdict.GATED and second is not None and second.distance < association.gate:
        if second.overlap < DOUBTFUL:
            return None
        sentence = (
            f"Left out, though {second.overlap:.0%} of it lies within the gate of spline {second.spline}, "
            f"{1000 * second.distance:.0f} mm off."
        )
        return Doubt(second.overlap, sentence, where[0], OnPiece(*where), overrule=(Force(*where, second.spline),))
    if spline is None or spline not in ids or not math.isfinite(association.distance):
        return None
    if second is not None and second.overlap >= BESIDE and second.distance < association.gate:
        closeness = 1.0 - min(abs(second.distance - association.distance) / association.gate, 1.0)
        if closeness < DOUBTFUL:
            return None
        sentence = (
            f"Given to spline {spline} at {1000 * association.distance:.0f} mm, while spline {second.spline} lies "
            f"{1000 * second.distance:.0f} mm off."
        )
        return Doubt(closeness, sentence, where[0], OnPiece(*where), overrule=(Force(*where, second.spline),))
    share = association.distance / association.gate
    if share < DOUBTFUL:
        return None
    sentence = f"Given to spline {spline} at {1000 * association.distance:.0f} of {1000 * association.gate:.0f} mm."
    return Doubt(min(share, 1.0), sentence, where[0], OnPiece(*where), overrule=(Forbid(*where, spline),))


def _of_hand(association: Association, ids: set[int]) -> Doubt | None:
    """The doubt about a piece that a person gave to a spline which it does not lie on."""
    spline = association.spline
    if spline is None or spline not in ids or not association.distance > association.gate:
        return None
    where = (association.scan, association.segment, association.first, association.last)
    far, allowed = 1000 * association.distance, 1000 * association.gate
    sentence = f"Given by hand to spline {spline}, {far:.0f} mm off where {allowed:.0f} mm are allowed."
    return Doubt(1.0, sentence, association.scan, OnPiece(*where), overrule=(Forbid(*where, spline),))


def _of_closures(snapshot: Snapshot, config: SlamConfig) -> Iterator[Doubt]:
    """Accepted closures that all the rest outvotes or that were hardly good enough, and rejected ones that nearly
    were."""
    keys = snapshot.key_scans
    for number, closure in enumerate(snapshot.loop_closures):
        if "hand" in closure.reason:
            continue
        margin = max(abs(closure.score - config.loops.least_score), abs(closure.inliers - config.loops.least_inliers))
        if not closure.accepted:
            near = 1.0 - min(margin / 0.1, 1.0)
            verdict = "not accepted so far" if closure.waiting else "rejected narrowly"
            yield Doubt(near, f"This loop closure was {verdict}: {closure.reason}.", closure.scan, closure=number)
            continue
        i, j = (snapshot.poses[keys[np.searchsorted(keys, scan)]] for scan in (closure.earlier, closure.scan))
        off = se2.between(closure.measured, se2.between(i, j))
        weight = robust_weight(_whitened(closure, off), config.loops.kernel)
        drop = (DropLoop(closure.earlier, closure.scan),)
        far = 1000 * float(np.hypot(off[0], off[1]))
        sentence = f"This loop closure is {far:.0f} mm off the map and keeps {weight:.0%} of its weight."
        yield Doubt(1.0 - weight, sentence, closure.scan, closure=number, overrule=drop)


def _whitened(closure: LoopClosure, off: np.ndarray) -> np.ndarray:
    return np.linalg.solve(np.linalg.cholesky(closure.covariance), off)
