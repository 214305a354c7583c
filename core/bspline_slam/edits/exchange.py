"""The terms that edits take out of a problem and those that they put in, as changes of its linear system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_array

from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.packing import CurveTerms, EdgeTerms, pack_curves, pack_edges
from bspline_slam.backends.pattern import Blocks, Pattern, find_pattern, linearise_terms
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.descent import Packed
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.loop_edits import pins
from bspline_slam.edits.problem import (
    Changes,
    linearised,
    moved_to,
    on_splines,
    owners,
    pinned,
    placed,
    pose_factors,
    whose_units,
)
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import Graph


@dataclass(frozen=True, eq=False, slots=True)
class Terms:
    """Some terms over all unknowns: poses, and all control points, those of the problem before those of splines that
    edits drew. `constant` is what no state can remove of their Σ‖e‖²."""

    curves: CurveTerms
    edges: EdgeTerms
    pattern: Pattern
    constant: float

    @classmethod
    def of(cls, curves: CurveTerms, edges: EdgeTerms, control_points: int, constant: float) -> Terms:
        """The same over so many control points."""
        return cls(curves, edges, find_pattern(curves, edges, control_points), constant)

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²)."""
        edges = self.edges.cost(state.poses)[0]
        return 0.5 * (self.curves.cost(state.poses, state.control_points) + edges + self.constant)

    def linearised(self, state: State, *, convex: bool = False) -> Linear:
        """Gradient and Newton's matrix at a state, or that of Gauss and Newton, which is `convex`."""
        blocks = linearise_terms(self.curves, self.edges, self.pattern, state)
        gradient = np.concatenate([blocks.gradient.poses.ravel(), blocks.gradient.control_points.ravel()])
        return Linear(gradient, _matrix(blocks if convex else blocks.newton(), self.pattern))


@dataclass(frozen=True, eq=False, slots=True)
class Linear:
    """What terms add to the gradient of the cost and to the matrix."""

    gradient: Float[np.ndarray, "u"]
    matrix: csr_array


def _matrix(blocks: Blocks, pattern: Pattern) -> csr_array:
    """The symmetric matrix of blocks over poses (x, y, θ) and then control points (x, y)."""
    poses, points = len(blocks.pose), 3 * len(blocks.pose)
    k, d = np.nonzero(pattern.curve_filled & blocks.curve.any(axis=(2, 3)))
    along, across = blocks.curve[k, d], d > 0
    filled = np.flatnonzero(blocks.pose.any(axis=(1, 2)))
    parts = [
        _entries(blocks.pose[filled], 3 * filled, 3 * filled),
        _entries(along, points + 2 * k, points + 2 * (k + d)),
        _entries(along[across].swapaxes(1, 2), points + 2 * (k + d)[across], points + 2 * k[across]),
    ]
    for block, row, column in (
        (blocks.edge, 3 * pattern.edges[:, 0], 3 * pattern.edges[:, 1]),
        (blocks.sight, points + 2 * pattern.sights[:, 0], 3 * pattern.sights[:, 1]),
    ):
        parts += [_entries(block, row, column), _entries(block.swapaxes(1, 2), column, row)]
    values, rows, columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    count = 3 * poses + 2 * len(blocks.curve)
    return csr_array((values, (rows, columns)), shape=(count, count))


def _entries(
    blocks: Float[np.ndarray, "k r c"], row: Int[np.ndarray, "k"], column: Int[np.ndarray, "k"]
) -> tuple[Float[np.ndarray, "e"], Int[np.ndarray, "e"], Int[np.ndarray, "e"]]:
    """Blocks as single entries: values, rows and columns."""
    r, c = np.indices(blocks.shape[1:])
    return blocks.ravel(), (row[:, None, None] + r).ravel(), (column[:, None, None] + c).ravel()


def robust_weight(residual: Float[np.ndarray, "r"], kernel: float | None) -> float:
    """What a Cauchy kernel leaves of the weight of a whitened residual."""
    return 1.0 if kernel is None else float(1.0 / (1.0 + residual @ residual / kernel**2))


def taken_out(ground: Ground, problem: Packed, decisions: Decisions, changes: Changes, control_points: int) -> Terms:
    """The terms of the ground's problem that edits make void, over so many control points."""
    graph = ground.estimate.graph
    factors = FlatFactors.of(graph.spline_factors)
    whose = owners(graph, factors.first)
    void = (factors.readings > 0) & (
        np.isin(whose, list(changes.drawn)) | whose_units(factors.pose, whose, changes.units)
    )
    held = sorted(ground.decisions.spline_pins.keys() & set(graph.spline_ids.tolist()))
    now = decisions.spline_pins
    loose = np.zeros(len(graph.shape_priors), dtype=bool)
    loose[len(loose) - len(held) :] = [now.get(s) is not ground.decisions.spline_pins[s] for s in held]
    kept = set(map(id, pose_factors(ground, decisions)))
    dropped = [id(factor) not in kept for factor in graph.pose_factors]
    free = [False, *(decisions.pose_pins.get(k) != pose for k, pose in sorted(ground.decisions.pose_pins.items()))]
    return Terms.of(
        problem.curves.only(np.concatenate([void, loose])),
        problem.edges.only(np.array([*dropped, *free], dtype=bool)),
        control_points,
        float(factors.constant[void].sum()),
    )


def put_in(
    ground: Ground, decisions: Decisions, changes: Changes, places: Mapping[int, int], control_points: int
) -> Terms:
    """The terms that edits bring in, linearised where the decisions are; `places` tell where each spline begins among
    so many control points."""
    old, new = ground.estimate.graph, linearised(ground, decisions, changes)
    told, drawn = FlatFactors.of(new.spline_factors), list(changes.drawn)
    come = (told.readings > 0) | np.isin(owners(new, told.first), drawn)
    bends = [term for term in on_splines(new, new.shape_priors) if term[0] in changes.drawn]
    pinned_before, posed_before = ground.decisions.spline_pins, ground.decisions.pose_pins
    spline_pins = {
        s: c for s, c in decisions.spline_pins.items() if s in changes.drawn or c is not pinned_before.get(s)
    }
    pose_pins = {k: pose for k, pose in decisions.pose_pins.items() if pose != posed_before.get(k)}
    fresh = replace(decisions, spline_pins=spline_pins, pose_pins=pose_pins)
    there = set(map(id, old.pose_factors))
    graph = Graph(
        key_scans=old.key_scans,
        poses=decisions.poses,
        spline_ids=np.zeros(0, dtype=np.int64),
        spline_first=np.zeros(1, dtype=np.int64),
        control_points=np.zeros((0, 2)),
        spline_factors=moved_to(new, told, come, places),
        pose_factors=tuple(factor for factor in pose_factors(ground, decisions) if id(factor) not in there),
        pose_priors=pins(fresh, ground.config.adjustment.anchor),
        shape_priors=(*placed(bends, places), *pinned(fresh, places)),
    )
    constant = float(told.constant[come].sum())
    return Terms.of(pack_curves(graph), pack_edges(graph), control_points, constant)
