"""The linear system of a pattern as a SciPy matrix: entries are copied from blocks by an index made once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State
from bspline_slam.backends.pattern import Blocks, Pattern


@dataclass(frozen=True, eq=False, slots=True)
class SparseSystem:
    """Unknowns are all poses (x, y, θ), then all control points (x, y).

    Entry k of the matrix is number `source[k]` of the blocks' entries, written one after another.
    """

    poses: int
    source: Int[np.ndarray, "z"]
    rows: Int[np.ndarray, "z"]
    column_start: Int[np.ndarray, "u1"]
    diagonal: Int[np.ndarray, "u"]

    @classmethod
    def from_pattern(cls, pattern: Pattern, poses: int) -> SparseSystem:
        """Lay out the full symmetric matrix of a pattern, column by column."""
        row, column, source = _entries(pattern, poses)
        mirrored = row != column
        rows, columns = np.append(row, column[mirrored]), np.append(column, row[mirrored])
        sources = np.append(source, source[mirrored])
        order = np.lexsort((rows, columns))
        rows, columns, sources = rows[order], columns[order], sources[order]
        unknowns = 3 * poses + 2 * len(pattern.curve_filled)
        start = np.searchsorted(columns, np.arange(unknowns + 1))
        return cls(poses, sources, rows.astype(np.int32), start.astype(np.int32), np.flatnonzero(rows == columns))

    def matrix(self, blocks: Blocks, damping: float = 0.0) -> csc_array:
        """H + (STEP_INFORMATION + damping)·I."""
        parts = (blocks.pose, blocks.edge, blocks.sight, blocks.curve)
        values = np.concatenate([part.ravel() for part in parts])[self.source]
        values[self.diagonal] += STEP_INFORMATION + damping
        unknowns = len(self.column_start) - 1
        return csc_array((values, self.rows, self.column_start), shape=(unknowns, unknowns))

    def stack(self, state: State) -> Float[np.ndarray, "u"]:
        """A state as one vector of unknowns."""
        return np.concatenate([state.poses.ravel(), state.control_points.ravel()])

    def unstack(self, unknowns: Float[np.ndarray, "u"]) -> State:
        """A vector of unknowns as a state."""
        return State(unknowns[: 3 * self.poses].reshape(-1, 3), unknowns[3 * self.poses :].reshape(-1, 2))


def factorise(matrix: csc_array) -> SuperLU:
    """Sparse factor of a symmetric positive definite matrix."""
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _entries(pattern: Pattern, poses: int) -> tuple[Int[np.ndarray, "z"], Int[np.ndarray, "z"], Int[np.ndarray, "z"]]:
    """Row, column and source of each entry of the blocks, of diagonal blocks the lower half only."""
    n, (N, w) = poses, pattern.curve_filled.shape
    points, reach = np.divmod(np.arange(N * w), max(w, 1))
    rows, columns = zip(
        _block_grid(3 * np.arange(n), 3 * np.arange(n), 3, 3),
        _block_grid(3 * pattern.edges[:, 0], 3 * pattern.edges[:, 1], 3, 3),
        _block_grid(3 * n + 2 * pattern.sights[:, 0], 3 * pattern.sights[:, 1], 2, 3),
        _block_grid(3 * n + 2 * points, 3 * n + 2 * (points + reach), 2, 2),
        strict=True,
    )
    row, column = np.concatenate(rows), np.concatenate(columns)
    keep = np.ones(len(row), dtype=bool)
    keep[: 9 * n] = row[: 9 * n] >= column[: 9 * n]
    in_curves = slice(len(row) - 4 * N * w, None)
    upper = (np.repeat(reach, 4) == 0) & (row[in_curves] < column[in_curves])
    keep[in_curves] = np.repeat(pattern.curve_filled.ravel(), 4) & ~upper
    source = np.flatnonzero(keep)
    return row[source], column[source], source


def _block_grid(
    row: Int[np.ndarray, "k"], column: Int[np.ndarray, "k"], height: int, width: int
) -> tuple[Int[np.ndarray, "z"], Int[np.ndarray, "z"]]:
    """Rows and columns of all entries of blocks whose first entries are given."""
    rows = np.broadcast_to(row[:, None, None] + np.arange(height)[:, None], (len(row), height, width))
    columns = np.broadcast_to(column[:, None, None] + np.arange(width), (len(row), height, width))
    return rows.ravel(), columns.ravel()
