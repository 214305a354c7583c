"""What a sparse Cholesky factor looks like before any number is known: tree, row structures, supernodes.

Nodes are blocks of unknowns. A supernode is a run of consecutive nodes whose columns have the same rows below them.
Source: Davis, "Direct Methods for Sparse Linear Systems", SIAM 2006, chapter 4; Ashcraft and Grimes, "The influence
of relaxed supernode partitions on the multifrontal method", ACM TOMS 15 (1989).
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def elimination_tree(start, neighbours, order, position):
    """Parent of each position (-1: root): the first later one that its column reaches."""
    n = len(order)
    parent, ancestor = np.full(n, -1), np.full(n, -1)
    for j in range(n):
        for k in range(start[order[j]], start[order[j] + 1]):
            i = position[neighbours[k]]
            while i >= 0 and i < j:
                above = ancestor[i]
                ancestor[i] = j
                if above < 0:
                    parent[i] = j
                i = above if above != j else -1
    return parent


@njit(cache=True, nogil=True)
def postorder(parent):
    """Positions in an order in which each tree is done before its root."""
    n = len(parent)
    child, sibling = np.full(n, -1), np.full(n, -1)
    for j in range(n - 1, -1, -1):
        if parent[j] >= 0:
            sibling[j] = child[parent[j]]
            child[parent[j]] = j
    order, stack, done = np.empty(n, np.int64), np.empty(n, np.int64), 0
    for root in range(n):
        if parent[root] >= 0:
            continue
        stack[0], top = root, 0
        while top >= 0:
            j = stack[top]
            if child[j] >= 0:
                top += 1
                stack[top] = child[j]
                child[j] = sibling[child[j]]
            else:
                order[done] = j
                done += 1
                top -= 1
    return order


@njit(cache=True, nogil=True)
def row_structures(start, neighbours, order, position, parent):
    """Later nodes in the column of each node: begins (n + 1) and positions, in any order within a column."""
    n = len(order)
    begin, rows = np.zeros(n + 1, np.int64), np.empty(8 * len(neighbours) + n, np.int64)
    child, sibling, mark = np.full(n, -1), np.full(n, -1), np.full(n, -1)
    for j in range(n):
        end = begin[j]
        if end + n > len(rows):
            grown = np.empty(2 * len(rows) + n, np.int64)
            for k in range(end):
                grown[k] = rows[k]
            rows = grown
        for k in range(start[order[j]], start[order[j] + 1]):
            i = position[neighbours[k]]
            if i > j and mark[i] != j:
                mark[i] = j
                rows[end] = i
                end += 1
        c = child[j]
        while c >= 0:
            for k in range(begin[c], begin[c + 1]):
                i = rows[k]
                if i > j and mark[i] != j:
                    mark[i] = j
                    rows[end] = i
                    end += 1
            c = sibling[c]
        begin[j + 1] = end
        if parent[j] >= 0:
            sibling[j] = child[parent[j]]
            child[parent[j]] = j
    return begin, rows


@njit(cache=True, nogil=True)
def supernode_ends(begin, parent, offset, slack, widest):
    """Position after the last node of each supernode.

    A run grows over its parent as long as that stores at most the fraction `slack` of zeros, or is tiny; no run is
    wider than `widest` unknowns. `offset` (n + 1) is where the unknowns of each node begin.
    """
    n = len(parent)
    ends, count, first, zeros = np.empty(n, np.int64), 0, 0, 0
    for j in range(n):
        joins = j + 1 < n and parent[j] == j + 1 and offset[j + 2] - offset[first] <= widest
        if joins:
            below, run = begin[j + 2] - begin[j + 1], j + 2 - first
            missing = (below + 1 - begin[j + 1] + begin[j]) * (run - 1)
            stored = run * (run + 1) // 2 + run * below
            if zeros + missing > slack * stored and run > 4:
                joins = False
            else:
                zeros += missing
        if not joins:
            ends[count], count, first, zeros = j + 1, count + 1, j + 1, 0
    return ends[:count]


@njit(cache=True, nogil=True)
def relative_rows(first, row_start, rows, row_place, parent, offset, relative_start):
    """Where the unknowns below each supernode lie in the front of its parent: its columns, then its rows.

    `row_place` is where the unknowns of each row node begin in the front of their supernode.
    """
    relative, place = np.empty(relative_start[-1], np.int64), np.empty(len(offset), np.int64)
    for s in range(len(parent)):
        p = parent[s]
        if p < 0:
            continue
        for j in range(first[p], first[p + 1]):
            place[j] = offset[j] - offset[first[p]]
        for k in range(row_start[p], row_start[p + 1]):
            place[rows[k]] = row_place[k]
        at = relative_start[s]
        for k in range(row_start[s], row_start[s + 1]):
            for a in range(offset[rows[k] + 1] - offset[rows[k]]):
                relative[at] = place[rows[k]] + a
                at += 1
    return relative


@njit(cache=True, nogil=True)
def panel_places(row, column, owner, first, row_start, rows, row_place, offset, panel_start, width):
    """Where blocks with these positions, row >= column, begin in the panels of the supernodes."""
    places = np.empty(len(row), np.int64)
    for k in range(len(row)):
        s = owner[column[k]]
        below = offset[row[k]] - offset[first[s]]
        if row[k] >= first[s + 1]:
            low, high = row_start[s], row_start[s + 1]
            while high - low > 1:
                middle = (low + high) // 2
                if rows[middle] <= row[k]:
                    low = middle
                else:
                    high = middle
            below = row_place[low]
        places[k] = panel_start[s] + below * width[s] + offset[column[k]] - offset[first[s]]
    return places
