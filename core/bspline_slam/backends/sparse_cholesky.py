"""The sparse matrix of a graph, factorised: order and structure are found once, numbers as often as needed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import coo_array

from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State
from bspline_slam.backends.pattern import Blocks, Pattern
from bspline_slam.backends.supernodes import Supernodes, find_supernodes
from bspline_slam.backends.threads import single_thread
from bspline_slam.errors import SolverError
from bspline_slam.kernels import cholesky, ordering, symbolic


@dataclass(frozen=True, eq=False, slots=True)
class Places:
    """Where blocks of one kind lie in the panels: first entry, length of a row there, whether transposed."""

    begin: Int[np.ndarray, "k"]
    stride: Int[np.ndarray, "k"]
    turned: Bool[np.ndarray, "k"]


@dataclass(frozen=True, eq=False, slots=True)
class Analysis:
    """Order of elimination and structure of the factor of a pattern; `order[k]` is the k-th unknown eliminated.

    Unknowns are numbered poses first (x, y, θ), then control points (x, y); so are the nodes, one for each.
    """

    pattern: Pattern
    poses: int
    order: Int[np.ndarray, "u"]
    supernodes: Supernodes
    pose: Places
    edge: Places
    sight: Places
    curve: Places

    @classmethod
    def from_pattern(cls, pattern: Pattern, poses: int) -> Analysis:
        """Order by minimum degree, follow the fill, and gather supernodes."""
        sizes = np.repeat([3, 2], [poses, len(pattern.curve_filled)])
        start, neighbours = _adjacency(pattern, poses)
        order = ordering.minimum_degree(start, neighbours, sizes)
        parent = symbolic.elimination_tree(start, neighbours, order, np.argsort(order))
        post = symbolic.postorder(parent)
        order = order[post]
        position = np.argsort(order)
        parent = np.append(np.argsort(post), -1)[parent[post]]
        begin, rows = symbolic.row_structures(start, neighbours, order, position, parent)
        nodes = find_supernodes(begin, rows, parent, sizes[order])
        first_unknown = np.cumsum(sizes) - sizes
        inner = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes[order]) - sizes[order], sizes[order])
        places = [Places(*nodes.places(position[a], position[b])) for a, b in _block_nodes(pattern, poses)]
        return cls(pattern, poses, np.repeat(first_unknown[order], sizes[order]) + inner, nodes, *places)

    def factorise(self, blocks: Blocks, damping: float = 0.0) -> Factor:
        """Factor of H + (STEP_INFORMATION + damping)·I. Raises SolverError naming what makes it singular."""
        nodes = self.supernodes
        panels, inverses = np.zeros(nodes.panel_start[-1]), np.empty(nodes.inverse_start[-1])
        curve = blocks.curve[self.pattern.curve_filled]
        for values, places in zip(
            (blocks.pose, blocks.edge, blocks.sight, curve), (self.pose, self.edge, self.sight, self.curve), strict=True
        ):
            cholesky.place_blocks(values, places.begin, places.stride, places.turned, panels)
        with single_thread():
            bad = cholesky.factorise(
                *(nodes.width, nodes.height, nodes.child, nodes.sibling, nodes.panel_start, nodes.inverse_start),
                *(nodes.update_start, nodes.relative_start, nodes.relative, STEP_INFORMATION + damping),
                *(panels, inverses, np.empty(nodes.update_size), np.empty(nodes.largest_below)),
                np.empty(nodes.largest_band),
            )
        if bad >= 0:
            raise SolverError(f"the problem is singular: nothing determines {self._name(int(self.order[bad]))}")
        return Factor(self, panels, inverses)

    def _name(self, unknown: int) -> str:
        if unknown < 3 * self.poses:
            return f"pose {unknown // 3}"
        return f"control point {(unknown - 3 * self.poses) // 2}"


@dataclass(frozen=True, eq=False, slots=True)
class Factor:
    """The Cholesky factor of one matrix."""

    analysis: Analysis
    panels: Float[np.ndarray, "z"]
    inverses: Float[np.ndarray, "i"]

    def solve(self, right: Float[np.ndarray, "u k"]) -> Float[np.ndarray, "u k"]:
        """H⁻¹ B."""
        nodes, order = self.analysis.supernodes, self.analysis.order
        x = np.ascontiguousarray(right[order])
        with single_thread():
            cholesky.solve(
                *(nodes.width, nodes.height, nodes.relative_start, nodes.rows, nodes.panel_start, nodes.inverse_start),
                *(self.panels, self.inverses, x),
            )
        solution = np.empty_like(x)
        solution[order] = x
        return solution

    def step(self, gradient: State) -> State:
        """−H⁻¹ gradient."""
        split = 3 * self.analysis.poses
        right = np.concatenate([gradient.poses.ravel(), gradient.control_points.ravel()])
        solution = -self.solve(right[:, None])[:, 0]
        return State(solution[:split].reshape(-1, 3), solution[split:].reshape(-1, 2))

    def inverse_blocks(self) -> tuple[Float[np.ndarray, "n 3 3"], Float[np.ndarray, "N w 2 2"]]:
        """Blocks of H⁻¹: of each pose, and of the pairs of control points in the pattern (others 0)."""
        analysis, nodes = self.analysis, self.analysis.supernodes
        result = np.empty_like(self.panels)
        with single_thread():
            cholesky.invert(
                *(nodes.width, nodes.height, nodes.parent, nodes.panel_start, nodes.inverse_start, nodes.later_start),
                *(nodes.relative_start, nodes.relative, self.panels, self.inverses, np.empty(nodes.later_size)),
                result,
            )
        filled = analysis.pattern.curve_filled
        pose, curve = np.empty((analysis.poses, 3, 3)), np.empty((int(filled.sum()), 2, 2))
        for blocks, places in ((pose, analysis.pose), (curve, analysis.curve)):
            cholesky.take_blocks(result, places.begin, places.stride, places.turned, blocks)
        all_curve = np.zeros((*filled.shape, 2, 2))
        all_curve[filled] = curve
        return pose, all_curve


Nodes = Int[np.ndarray, "k"]


def _block_nodes(pattern: Pattern, poses: int) -> list[tuple[Nodes, Nodes]]:
    """Row and column nodes of all blocks: of poses, edges, sights and curves."""
    diagonal = np.arange(poses)
    point, reach = np.nonzero(pattern.curve_filled)
    return [
        (diagonal, diagonal),
        (pattern.edges[:, 0], pattern.edges[:, 1]),
        (poses + pattern.sights[:, 0], pattern.sights[:, 1]),
        (poses + point, poses + point + reach),
    ]


def _adjacency(pattern: Pattern, poses: int) -> tuple[Int[np.ndarray, "n1"], Int[np.ndarray, "z"]]:
    """Neighbours of all nodes: begins and nodes."""
    row, column = (np.concatenate(nodes) for nodes in zip(*_block_nodes(pattern, poses), strict=True))
    apart = row != column
    row, column = row[apart], column[apart]
    count = poses + len(pattern.curve_filled)
    both = (np.append(row, column), np.append(column, row))
    matrix = coo_array((np.ones(2 * len(row), dtype=np.int8), both), shape=(count, count)).tocsr()
    return matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64)
