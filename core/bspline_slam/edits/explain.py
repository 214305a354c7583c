"""What the solver did with edits: the cost by kind of factor, the worst residuals, and what became of each edit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import Estimate
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, Edit, Force, MakeNew, OnPiece, PinPose, PinSpline
from bspline_slam.edits.exchange import robust_weight
from bspline_slam.edits.piece_edits import across, facing
from bspline_slam.edits.problem import owners
from bspline_slam.errors import EditError, as_sentence
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.slam import SlamConfig, Snapshot

WORST = 10
FOLLOWED = 0.5
"""An edit that keeps less than this share of its weight is outvoted."""
KINDS: tuple[str, ...] = ("beams on curves", "odometry", "scan matching", "loop closures", "shape of curves", "pins")
POSE_KINDS = {"odometry": "odometry", "matching": "scan matching", "loop": "loop closures"}


class Fate(Enum):
    """What became of an edit."""

    FOLLOWED = "followed"
    OUTVOTED = "outvoted"
    SKIPPED = "left out"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one edit, in a sentence; `residual` is what is left of its distance (m), `weight` the share of its
    say that the robust kernel leaves it."""

    fate: Fate
    sentence: str
    residual: float | None = None
    weight: float | None = None


@dataclass(frozen=True, slots=True)
class Worst:
    """One of the largest residuals: `size` is its RMS over the standard deviation, `metres` its RMS distance.

    It belongs to the key scan `scan`, and either to its `segment` and the spline `spline`, or to the tie of that `kind`
    with the key scan `other`.
    """

    kind: str
    size: float
    metres: float
    scan: int
    segment: int | None = None
    spline: int | None = None
    other: int | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """Costs (½Σρ with what no state can remove) by kind of factor before and after, how many beams count in them before
    and after, the worst residuals after, what became of each edit, and how far each key pose moved (m).

    A beam that counts no more costs nothing, so costs alone do not tell which of two maps is the better one."""

    before: dict[str, float]
    after: dict[str, float]
    beams: tuple[int, int]
    worst: tuple[Worst, ...]
    outcomes: tuple[Outcome, ...]
    moves: Float[np.ndarray, "n"]


def explain(
    base: Snapshot,
    after: Snapshot,
    edits: Sequence[Edit],
    skipped: Sequence[str | None],
    config: SlamConfig,
    before: Mapping[str, float] | None = None,
) -> Explanation:
    """What edits did to a solved result; `before` are its costs where they are at hand."""
    assert base.estimate is not None and after.estimate is not None
    decisions = Decisions.of(after)
    outcomes = (
        Outcome(Fate.SKIPPED, as_sentence(reason)) if reason else outcome(edit, decisions, config)
        for edit, reason in zip(edits, skipped, strict=True)
    )
    moves = np.linalg.norm((decisions.poses - Decisions.of(base).poses)[:, :2], axis=1)
    terms = Residuals.of(after.estimate)
    costs_before = dict(before) if before is not None else costs(base.estimate)
    counted = (counted_beams(base.estimate), counted_beams(after.estimate))
    return Explanation(costs_before, terms.costs, counted, worst_residuals(after, terms), tuple(outcomes), moves)


def costs(estimate: Estimate) -> dict[str, float]:
    """The cost at an estimate by kind of factor."""
    return Residuals.of(estimate).costs


def counted_beams(estimate: Estimate) -> int:
    """How many beams say something of a curve in an estimate."""
    return int(FlatFactors.of(estimate.graph.spline_factors).readings.sum())


@dataclass(frozen=True, eq=False, slots=True)
class Residuals:
    """Σ‖e‖² of each term at an estimate: of spline factors, with what no state can remove, of shape priors and of pose
    priors; and of pose factors e itself, with how far (m) the poses lie from where each has them."""

    estimate: Estimate
    factors: Float[np.ndarray, "f"]
    shapes: Float[np.ndarray, "p"]
    priors: float
    ties: Float[np.ndarray, "t 3"]
    away: Float[np.ndarray, "t"]

    @classmethod
    def of(cls, estimate: Estimate) -> Residuals:
        """Those at an estimate."""
        graph, poses = estimate.graph, estimate.poses
        curves, edges, factors = pack_curves(graph), pack_edges(graph), FlatFactors.of(graph.spline_factors)
        squares, ties = curves.squares(poses, estimate.control_points), edges.first(len(graph.pose_factors))
        off = se2.between(ties.measured, se2.between(poses[ties.tail], poses[ties.head]))
        held = edges.only(slice(len(graph.pose_factors), None)).cost(poses)[0]
        return cls(
            estimate,
            squares[: len(factors)] + factors.constant,
            squares[len(factors) :],
            held,
            np.einsum("tij,tj->ti", ties.sqrt_information, off),
            np.hypot(off[:, 0], off[:, 1]),
        )

    @property
    def costs(self) -> dict[str, float]:
        """The cost by kind of factor."""
        graph, found = self.estimate.graph, dict.fromkeys(KINDS, 0.0)
        beams = FlatFactors.of(graph.spline_factors).readings > 0
        found["beams on curves"] = 0.5 * float(self.factors[beams].sum())
        found["shape of curves"] = 0.5 * float(self.factors[~beams].sum() + self.shapes.sum())
        found["pins"] = 0.5 * self.priors
        kinds, costs = np.array([factor.kind for factor in graph.pose_factors]), self._tie_costs()
        for kind, name in POSE_KINDS.items():
            found[name] = float(costs[kinds == kind].sum())
        return found

    def _tie_costs(self) -> Float[np.ndarray, "t"]:
        """½ρ of each tie between two poses."""
        squares = np.square(self.ties).sum(1)
        widths = np.square([np.inf if f.kernel is None else f.kernel for f in self.estimate.graph.pose_factors])
        robust = np.isfinite(widths)
        squares[robust] = widths[robust] * np.log1p(squares[robust] / widths[robust])
        return 0.5 * squares


# -- residuals -----------------------------------------------------------------------------------------------------
def worst_residuals(after: Snapshot, terms: Residuals) -> tuple[Worst, ...]:
    """The pieces and ties that disagree most with a solved result."""
    found = [*_worst_pieces(after, terms), *_worst_ties(terms)]
    return tuple(sorted(found, key=lambda worst: -worst.size)[:WORST])


def _worst_pieces(after: Snapshot, terms: Residuals) -> list[Worst]:
    graph, decisions = terms.estimate.graph, Decisions.of(after)
    factors = FlatFactors.of(graph.spline_factors)
    sizes = np.where(factors.readings > 0, np.sqrt(terms.factors / np.maximum(factors.measured, 1)), 0.0)
    worst = np.argsort(-sizes, kind="stable")[:WORST]
    splines = owners(graph, factors.first[worst])
    told = zip(sizes[worst].tolist(), factors.pose[worst].tolist(), splines.tolist(), strict=True)
    return [_piece(decisions, size, number, spline) for size, number, spline in told]


def _piece(decisions: Decisions, size: float, number: int, spline: int) -> Worst:
    """What one key scan says of one spline, named by the piece that lies farthest from it."""
    key = decisions.keys[number]
    pieces = [OnPiece(key.scan, a.segment, a.first, a.last) for a in key.associations if a.spline == spline]
    off = [rms(across(decisions.splines[spline], decisions.points(piece))) for piece in pieces]
    farthest = int(np.argmax(off))
    return Worst("beams on curves", size, off[farthest], key.scan, pieces[farthest].segment, spline)


def _worst_ties(terms: Residuals) -> list[Worst]:
    graph, sizes = terms.estimate.graph, np.sqrt(np.square(terms.ties).mean(1))
    scans, out = graph.key_scans, []
    for k in np.argsort(-sizes, kind="stable")[:WORST].tolist():
        factor = graph.pose_factors[k]
        kind, scan, other = POSE_KINDS[factor.kind], int(scans[factor.j]), int(scans[factor.i])
        out.append(Worst(kind, float(sizes[k]), float(terms.away[k]), scan, other=other))
    return out


def rms(values: Float[np.ndarray, "m"]) -> float:
    """Root mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


# -- edits ---------------------------------------------------------------------------------------------------------
def outcome(edit: Edit, decisions: Decisions, config: SlamConfig) -> Outcome:
    """What became of an edit that was made."""
    match edit:
        case Force() | MakeNew():
            return _given(edit, decisions, config)
        case CloseLoop():
            return _closed(edit, decisions, config)
        case PinPose():
            pose = decisions.poses[decisions.number(edit.scan)]
            away = float(np.hypot(*(pose - np.array(edit.pose))[:2]))
            return Outcome(Fate.FOLLOWED, f"The pose stays within {1000 * away:.1f} mm of its pin.", away, 1.0)
        case PinSpline() if edit.spline in decisions.splines:
            curve, pin = decisions.splines[edit.spline].curve, edit.curve
            if not np.array_equal(curve.knots, pin.knots):
                return Outcome(Fate.OUTVOTED, "The curve was drawn anew later and is pinned no longer.", None, 0.0)
            moved = curve.control_points - pin.control_points
            away = float(np.linalg.norm(moved, axis=1).max())
            return Outcome(Fate.FOLLOWED, f"The curve stays within {1000 * away:.1f} mm of its pin.", away, 1.0)
        case _:
            return Outcome(Fate.FOLLOWED, "The map agrees with it.")


def _given(edit: Force | MakeNew, decisions: Decisions, config: SlamConfig) -> Outcome:
    """Whether beams lie on the spline that they were given to; those that see it from behind, or end beside it, count
    for nothing."""
    try:
        points = decisions.points(edit)
    except EditError as error:
        return Outcome(Fate.SKIPPED, f"{error}.")
    off = facing(decisions, edit) if edit.spline in decisions.splines else np.zeros(0)
    if len(off) == 0:
        return Outcome(Fate.OUTVOTED, "None of its beams faces the spline, so they say nothing.", None, 0.0)
    limit = config.adjustment.outlier * config.fitting.range_noise
    kept = np.minimum(1.0, np.square(limit / np.maximum(np.abs(off), 1e-9)))
    weight = float(kept.sum() / len(points))
    whose = "The beams" if len(off) == len(points) else f"{len(off)} of its {len(points)} beams face the spline: they"
    distance = f"{whose} end {1000 * rms(off):.0f} mm from the spline and keep {weight:.0%} of their weight."
    fate = Fate.FOLLOWED if weight >= FOLLOWED else Fate.OUTVOTED
    return Outcome(fate, distance, rms(off), weight)


def _closed(edit: CloseLoop, decisions: Decisions, config: SlamConfig) -> Outcome:
    """Whether two poses lie as a closure says."""
    i, j = (decisions.poses[decisions.number(scan)] for scan in (edit.earlier, edit.scan))
    off = se2.between(np.array(edit.measured), se2.between(i, j))
    weight = robust_weight(np.array(edit.sqrt_information) @ off, config.loops.kernel)
    away = float(np.hypot(off[0], off[1]))
    sentence = f"The scans lie {1000 * away:.0f} mm and {np.degrees(abs(off[2])):.2f}° off; it keeps {weight:.0%}."
    return Outcome(Fate.FOLLOWED if weight >= FOLLOWED else Fate.OUTVOTED, sentence, away, weight)
