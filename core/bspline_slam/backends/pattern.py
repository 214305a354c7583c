"""Where the matrix of a graph is not zero, in blocks; found once per solve."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.packing import CurveTerms, EdgeTerms
from bspline_slam.kernels import gradient as gradients
from bspline_slam.kernels import linearise


@dataclass(frozen=True, eq=False, slots=True)
class Pattern:
    """The blocks below the diagonal that some term fills.

    `edges` are pairs of poses i < j and `edge_slot` the pair of each edge term (0 for priors). `sights` are pairs
    (control point, pose), `sight_slot` where those of a curve term begin. `curve_filled` says of control points k
    and k + d whether one term holds both.
    """

    edges: Int[np.ndarray, "p 2"]
    edge_slot: Int[np.ndarray, "e"]
    sights: Int[np.ndarray, "q 2"]
    sight_slot: Int[np.ndarray, "f"]
    curve_filled: Bool[np.ndarray, "N w"]


@dataclass(frozen=True, eq=False, slots=True)
class Blocks:
    """Gradient and Gauss-Newton matrix in the blocks of a pattern (shapes: `kernels.linearise`).

    `bent_*` are what the matrix of Newton has beyond that: residuals times second derivatives, and robust kernels that
    grow flatter.
    """

    pose: Float[np.ndarray, "n 3 3"]
    edge: Float[np.ndarray, "p 3 3"]
    sight: Float[np.ndarray, "q 2 3"]
    curve: Float[np.ndarray, "N w 2 2"]
    gradient: State
    bent_pose: Float[np.ndarray, "n 3 3"]
    bent_edge: Float[np.ndarray, "p 3 3"]
    bent_sight: Float[np.ndarray, "q 2 3"]

    def newton(self) -> Blocks:
        """The same with the matrix of Newton in place of that of Gauss and Newton; it may be indefinite."""
        return replace(
            self,
            pose=self.pose + self.bent_pose,
            edge=self.edge + self.bent_edge,
            sight=self.sight + self.bent_sight,
        )


def find_pattern(curves: CurveTerms, edges: EdgeTerms, control_points: int) -> Pattern:
    """The pattern of these terms over so many control points."""
    pairs, edge_slot = _edge_pairs(edges)
    sights, sight_slot = _sights(curves, control_points)
    return Pattern(pairs, edge_slot, sights, sight_slot, _curve_filled(curves, control_points))


def _edge_pairs(edges: EdgeTerms) -> tuple[Int[np.ndarray, "p 2"], Int[np.ndarray, "e"]]:
    between, count = edges.tail >= 0, int(edges.head.max(initial=0)) + 1
    low, high = np.minimum(edges.tail, edges.head), np.maximum(edges.tail, edges.head)
    keys, inverse = np.unique((low * count + high)[between], return_inverse=True)
    slot = np.zeros(len(edges.head), dtype=np.int64)
    slot[between] = inverse
    return np.column_stack([keys // count, keys % count]), slot


def _sights(curves: CurveTerms, control_points: int) -> tuple[Int[np.ndarray, "q 2"], Int[np.ndarray, "f"]]:
    """Unique pairs, sorted by pose and then control point: those of one term are consecutive."""
    observed = curves.observer >= 0
    width = np.where(observed, curves.size[:, 1], 0)
    begins = np.cumsum(width) - width
    offset = np.arange(width.sum()) - np.repeat(begins, width)
    keys = np.repeat(curves.observer * control_points + curves.first, width) + offset
    unique, inverse = np.unique(keys, return_inverse=True)
    slot = np.zeros(len(width), dtype=np.int64)
    slot[observed] = inverse[begins[observed]]
    return np.column_stack([unique % max(control_points, 1), unique // max(control_points, 1)]), slot


def _curve_filled(curves: CurveTerms, control_points: int) -> Bool[np.ndarray, "N w"]:
    widest = int(curves.size[:, 1].max(initial=1))
    keys = np.unique(curves.first * (widest + 1) + curves.size[:, 1])
    return _fill_windows(
        np.eye(1, widest, dtype=bool).repeat(control_points, 0), keys // (widest + 1), keys % (widest + 1)
    )


def _fill_windows(
    filled: Bool[np.ndarray, "N w"], first: Int[np.ndarray, "k"], width: Int[np.ndarray, "k"]
) -> Bool[np.ndarray, "N w"]:
    """Fill all pairs inside each window of control points first … first + width − 1."""
    for m in np.unique(width):
        begins = first[width == m]
        for k in range(m):
            filled[begins + k, : m - k] = True
    return filled


def fill_splines(pattern: Pattern, spline_first: Int[np.ndarray, "s1"]) -> Pattern:
    """The pattern with all pairs of control points of one spline filled, seen together or not."""
    count, seen = pattern.curve_filled.shape
    widths = np.diff(spline_first)
    filled = np.zeros((count, max(seen, int(widths.max(initial=1)))), dtype=bool)
    filled[:, :seen] = pattern.curve_filled
    return replace(pattern, curve_filled=_fill_windows(filled, spline_first[:-1], widths))


def linearise_terms(curves: CurveTerms, edges: EdgeTerms, pattern: Pattern, state: State) -> Blocks:
    """Gradient and Gauss-Newton matrix of all terms at a state."""
    n, (N, w) = len(state.poses), pattern.curve_filled.shape
    blocks = Blocks(
        np.zeros((n, 3, 3)),
        np.zeros((len(pattern.edges), 3, 3)),
        np.zeros((len(pattern.sights), 2, 3)),
        np.zeros((N, w, 2, 2)),
        State(np.zeros((n, 3)), np.zeros((N, 2))),
        np.zeros((n, 3, 3)),
        np.zeros((len(pattern.edges), 3, 3)),
        np.zeros((len(pattern.sights), 2, 3)),
    )
    if len(curves.first):
        linearise.linearise_curves(
            *(state.poses, state.control_points, curves.observer, curves.first, curves.size, curves.start),
            *(curves.A, curves.b, curves.gram, pattern.sight_slot),
            *(blocks.pose, blocks.sight, blocks.curve, blocks.gradient.poses, blocks.gradient.control_points),
            *(blocks.bent_pose, blocks.bent_sight),
        )
    linearise.linearise_edges(
        *(state.poses, edges.tail, edges.head, edges.measured, edges.sqrt_information, edges.kernel),
        *(pattern.edge_slot, blocks.pose, blocks.edge, blocks.gradient.poses, blocks.bent_pose, blocks.bent_edge),
    )
    return blocks


def gradient_of(curves: CurveTerms, edges: EdgeTerms, state: State) -> State:
    """The gradient of ½ Σ ρ(‖e‖²) alone: a third of the work of `linearise_terms`."""
    n = len(state.poses)
    found = State(np.zeros((n, 3)), np.zeros((len(state.control_points), 2)))
    if len(curves.first):
        gradients.curve_gradient(
            *(state.poses, state.control_points, curves.observer, curves.first, curves.size, curves.start),
            *(curves.A, curves.b, found.poses, found.control_points),
        )
    linearise.linearise_edges(
        *(state.poses, edges.tail, edges.head, edges.measured, edges.sqrt_information, edges.kernel),
        *(np.zeros(len(edges.head), dtype=np.int64), np.zeros((n, 3, 3)), np.zeros((1, 3, 3)), found.poses),
        *(np.zeros((n, 3, 3)), np.zeros((1, 3, 3))),
    )
    return found
