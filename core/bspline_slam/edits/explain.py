"""What the solver did with edits: the cost by kind of factor, the worst residuals, and what became of each edit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import Estimate
from bspline_slam.backends.statistics import measured, measures
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, Edit, Force, MakeNew, OnPiece, PinPose, PinSpline
from bspline_slam.edits.exchange import robust_weight
from bspline_slam.edits.piece_edits import across
from bspline_slam.edits.problem import on_splines
from bspline_slam.errors import EditError
from bspline_slam.graph import PoseFactor
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
    """Costs (½Σρ with what no state can remove) by kind of factor before and after, the worst residuals after, what
    became of each edit, and how far each key pose moved (m)."""

    before: dict[str, float]
    after: dict[str, float]
    worst: tuple[Worst, ...]
    outcomes: tuple[Outcome, ...]
    moves: Float[np.ndarray, "n"]


def explain(
    base: Snapshot, after: Snapshot, edits: Sequence[Edit], skipped: Sequence[str | None], config: SlamConfig
) -> Explanation:
    """What edits did to a solved result."""
    assert base.estimate is not None and after.estimate is not None
    decisions = Decisions.of(after)
    outcomes = (
        Outcome(Fate.SKIPPED, f"{reason[:1].upper()}{reason[1:]}.") if reason else outcome(edit, decisions, config)
        for edit, reason in zip(edits, skipped, strict=True)
    )
    moves = np.linalg.norm((decisions.poses - Decisions.of(base).poses)[:, :2], axis=1)
    return Explanation(costs(base.estimate), costs(after.estimate), worst_residuals(after), tuple(outcomes), moves)


def costs(estimate: Estimate) -> dict[str, float]:
    """The cost at an estimate by kind of factor."""
    graph, poses, points = estimate.graph, estimate.poses, estimate.control_points
    found = dict.fromkeys(KINDS, 0.0)
    curves, beams = pack_curves(graph), measured(graph)
    constant = sum(factor.constant for factor in graph.spline_factors)
    found["beams on curves"] = 0.5 * (curves.only(beams).cost(poses, points) + constant)
    found["shape of curves"] = 0.5 * curves.only(~beams).cost(poses, points)
    for factor in graph.pose_factors:
        found[POSE_KINDS[factor.kind]] += pose_factor_cost(factor, poses)
    edges = pack_edges(graph)
    relative = sum(found[kind] for kind in POSE_KINDS.values())
    found["pins"] = max(0.5 * edges.cost(poses)[0] - relative, 0.0)
    return found


def pose_factor_cost(factor: PoseFactor, poses: Float[np.ndarray, "n 3"]) -> float:
    """½ρ of a tie between two poses."""
    residual = factor.residual(poses[factor.i], poses[factor.j])
    square = float(residual @ residual)
    return 0.5 * (square if factor.kernel is None else factor.kernel**2 * np.log1p(square / factor.kernel**2))


# -- residuals -----------------------------------------------------------------------------------------------------
def worst_residuals(after: Snapshot) -> tuple[Worst, ...]:
    """The pieces and ties that disagree most with a solved result."""
    assert after.estimate is not None
    found = [*_worst_pieces(after, after.estimate), *_worst_ties(after.estimate)]
    return tuple(sorted(found, key=lambda worst: -worst.size)[:WORST])


def _worst_pieces(after: Snapshot, estimate: Estimate) -> list[Worst]:
    graph, poses, points = estimate.graph, estimate.poses, estimate.control_points
    decisions = Decisions.of(after)
    sizes = []
    for spline, _, factor in on_splines(graph, graph.spline_factors):
        if measures(factor):
            seen = points[factor.first : factor.first + factor.A.shape[1] // 2]
            residual = factor.residual(poses[factor.pose], seen)
            rows = factor.readings if factor.constant > 0 else len(factor.b)
            sizes.append((float(np.sqrt((residual @ residual + factor.constant) / rows)), factor.pose, spline))
    sizes.sort(key=lambda one: -one[0])
    return [_piece(decisions, size, number, spline) for size, number, spline in sizes[:WORST]]


def _piece(decisions: Decisions, size: float, number: int, spline: int) -> Worst:
    """What one key scan says of one spline, named by the piece that lies farthest from it."""
    key = decisions.keys[number]
    pieces = [OnPiece(key.scan, a.segment, a.first, a.last) for a in key.associations if a.spline == spline]
    off = [rms(across(decisions.splines[spline], decisions.points(piece))) for piece in pieces]
    farthest = int(np.argmax(off))
    return Worst("beams on curves", size, off[farthest], key.scan, pieces[farthest].segment, spline)


def _worst_ties(estimate: Estimate) -> list[Worst]:
    out = []
    for factor in estimate.graph.pose_factors:
        i, j = estimate.poses[factor.i], estimate.poses[factor.j]
        residual = factor.residual(i, j)
        off = se2.between(factor.measured, se2.between(i, j))
        scans = estimate.graph.key_scans
        size, away = float(np.sqrt(residual @ residual / 3)), float(np.hypot(off[0], off[1]))
        other = int(scans[factor.i])
        out.append(Worst(POSE_KINDS[factor.kind], size, away, int(scans[factor.j]), other=other))
    return sorted(out, key=lambda worst: -worst.size)[:WORST]


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
    """Whether beams lie on the spline that they were given to."""
    try:
        points = decisions.points(edit)
    except EditError as error:
        return Outcome(Fate.SKIPPED, f"{error}.")
    if edit.spline not in decisions.splines:
        return Outcome(Fate.OUTVOTED, "None of its beams faces the spline, so they say nothing.", None, 0.0)
    off = across(decisions.splines[edit.spline], points)
    limit = config.adjustment.outlier * config.fitting.range_noise
    weight = float(np.mean(np.minimum(1.0, np.square(limit / np.maximum(np.abs(off), 1e-9)))))
    distance = f"The beams end {1000 * rms(off):.0f} mm from the spline and keep {weight:.0%} of their weight."
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
