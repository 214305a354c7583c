"""Supernodes of a sparse Cholesky factor and the layout of their panels, updates and fronts in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from bspline_slam.kernels import cholesky, symbolic

SLACK = 0.2
"""Fraction of zeros that a supernode may store in exchange for being wider."""
WIDEST = 96
"""Unknowns per supernode; its triangle is factorised and inverted by plain loops."""

Ints = Int[np.ndarray, "_"]


@dataclass(frozen=True, eq=False, slots=True)
class Supernodes:
    """The structure of a factor, in the arrays that `kernels.cholesky` reads; positions are those in the order.

    Nodes of supernode s are first[s] … first[s + 1] − 1, its unknowns width[s] columns and height[s] rows below
    them. `owner`, `offset` and `row_place` serve to find blocks, `rows` are the unknowns below, `relative` their
    places in the front of the parent.
    """

    first: Ints
    owner: Ints
    offset: Ints
    width: Ints
    height: Ints
    parent: Ints
    child: Ints
    sibling: Ints
    row_start: Ints
    row_nodes: Ints
    row_place: Ints
    relative_start: Ints
    relative: Ints
    rows: Ints
    panel_start: Ints
    inverse_start: Ints
    update_start: Ints
    update_size: int
    later_start: Ints
    later_size: int

    @property
    def largest_below(self) -> int:
        """Entries of the largest L_UJ."""
        return int((self.height * self.width).max(initial=0))

    @property
    def largest_band(self) -> int:
        """Entries of the largest band of rows of an update."""
        return cholesky.BAND * int(self.height.max(initial=0))

    def places(self, row: Ints, column: Ints) -> tuple[Ints, Ints, Bool[np.ndarray, "_"]]:
        """Of blocks at these positions: first entry in the panels, length of a row there, whether transposed."""
        low, high = np.minimum(row, column), np.maximum(row, column)
        begin = symbolic.panel_places(
            *(high, low, self.owner, self.first, self.row_start, self.row_nodes, self.row_place, self.offset),
            *(self.panel_start, self.width),
        )
        return begin, self.width[self.owner[low]], row < column


def find_supernodes(begin: Ints, rows: Ints, parent: Ints, sizes: Ints) -> Supernodes:
    """Gather nodes with (nearly) the same rows. Rows of node j are rows[begin[j] : begin[j + 1]]."""
    offset = _starts(sizes)
    ends = symbolic.supernode_ends(begin, parent, offset, SLACK, WIDEST)
    first = np.append(0, ends)
    owner = np.repeat(np.arange(len(ends)), np.diff(first))
    row_count = begin[ends] - begin[ends - 1]
    row_start = _starts(row_count)
    row_nodes = np.concatenate([np.sort(rows[begin[end - 1] : begin[end]]) for end in ends])
    row_sizes = sizes[row_nodes]
    row_offset = _starts(row_sizes)
    relative_start, width = row_offset[row_start], np.diff(offset[first])
    height = np.diff(relative_start)
    row_place = row_offset[:-1] + np.repeat(width - relative_start[:-1], row_count)
    above = np.full(len(ends), -1)
    above[row_count > 0] = owner[row_nodes[row_start[:-1][row_count > 0]]]
    relative = symbolic.relative_rows(first, row_start, row_nodes, row_place, above, offset, relative_start)
    inner = np.arange(row_offset[-1]) - np.repeat(row_offset[:-1], row_sizes)
    child, sibling = _children(above)
    update_start, update_size = _update_layout(above, height)
    later_start, later_size = _later_layout(above, height)
    return Supernodes(
        *(first, owner, offset, width, height, above, child, sibling, row_start, row_nodes, row_place),
        *(relative_start, relative, np.repeat(offset[row_nodes], row_sizes) + inner),
        *(_starts((width + height) * width), _starts(width * width)),
        *(update_start, update_size, later_start, later_size),
    )


def _starts(lengths: Ints) -> Ints:
    """Where each of consecutive pieces begins, and where the last one ends."""
    return np.append(0, np.cumsum(lengths))


def _children(parent: Ints) -> tuple[Ints, Ints]:
    """First child and next sibling of each supernode."""
    child, sibling = np.full(len(parent), -1), np.full(len(parent), -1)
    for s in range(len(parent) - 1, -1, -1):
        if parent[s] >= 0:
            sibling[s], child[parent[s]] = child[parent[s]], s
    return child, sibling


def _update_layout(parent: Ints, height: Ints) -> tuple[Ints, int]:
    """Updates on two stacks, by even and odd depth, so that a supernode never overwrites those of its children."""
    depth, taken = np.zeros(len(parent), dtype=np.int64), np.zeros(len(parent), dtype=np.int64)
    for s in range(len(parent) - 1, -1, -1):
        depth[s] = depth[parent[s]] + 1 if parent[s] >= 0 else 0
    start, top, highest = np.zeros(len(parent), dtype=np.int64), [0, 0], [0, 0]
    for s in range(len(parent)):
        side = depth[s] % 2
        top[1 - side] -= taken[s]
        start[s] = top[side]
        top[side] += height[s] ** 2
        highest[side] = max(highest[side], top[side])
        if parent[s] >= 0:
            taken[parent[s]] += height[s] ** 2
    return start + np.where(depth % 2 == 1, highest[0], 0), int(sum(highest))


def _later_layout(parent: Ints, height: Ints) -> tuple[Ints, int]:
    """Inverses of the rows below, each behind those of the ancestors: no others are needed at its turn."""
    start = np.zeros(len(parent), dtype=np.int64)
    for s in range(len(parent) - 1, -1, -1):
        if parent[s] >= 0:
            start[s] = start[parent[s]] + height[parent[s]] ** 2
    return start, int((start + height**2).max(initial=0))
