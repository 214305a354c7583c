"""Multifrontal Cholesky by supernodes, solves with it, and the part of the inverse that lies in its pattern.

Supernode s has width[s] columns and height[s] rows below them. Its panel, (width + height) x width, holds the matrix
before and L after the factorisation; `inverses` holds the inverse of its triangle L_JJ. The update of s is what its
columns subtract from the later ones; it waits in `updates` until its parent takes it, `relative` says where to.
Sources: Liu, "The multifrontal method for sparse matrix solution", SIAM Review 34 (1992); Takahashi, Fagan, Chen 1973.
"""

import numpy as np
from numba import njit

BAND = 128
"""Rows of an update that are multiplied at once."""


@njit(cache=True, nogil=True)
def place_blocks(blocks, places, stride, turned, panels):
    """Add blocks (k, a, b) to the panels, transposed where `turned`."""
    for k in range(len(places)):
        for a in range(blocks.shape[1]):
            for b in range(blocks.shape[2]):
                if turned[k]:
                    panels[places[k] + b * stride[k] + a] += blocks[k, a, b]
                else:
                    panels[places[k] + a * stride[k] + b] += blocks[k, a, b]


@njit(cache=True, nogil=True)
def take_blocks(panels, places, stride, turned, blocks):
    """The opposite of `place_blocks`: read blocks (k, a, b) from the panels."""
    for k in range(len(places)):
        for a in range(blocks.shape[1]):
            for b in range(blocks.shape[2]):
                if turned[k]:
                    blocks[k, a, b] = panels[places[k] + b * stride[k] + a]
                else:
                    blocks[k, a, b] = panels[places[k] + a * stride[k] + b]


@njit(cache=True, nogil=True)
def factorise(
    width, height, child, sibling, panel_start, inverse_start, update_start, relative_start, relative, shift, panels,
    inverses, updates, scratch, band,
):  # fmt: skip
    """Factor the panels plus `shift` on the diagonal; returns the first column whose pivot is not positive, or −1."""
    column = 0
    for s in range(len(width)):
        w, u = width[s], height[s]
        panel = panels[panel_start[s] : panel_start[s] + (w + u) * w].reshape(w + u, w)
        c = child[s]
        while c >= 0:
            moved = relative[relative_start[c] : relative_start[c + 1]]
            update = updates[update_start[c] : update_start[c] + height[c] ** 2].reshape(height[c], height[c])
            _take_columns(update, moved, w, panel)
            c = sibling[c]
        for i in range(w):
            panel[i, i] += shift
        inverse = inverses[inverse_start[s] : inverse_start[s] + w * w].reshape(w, w)
        bad = _triangle(panel, w, inverse)
        if bad >= 0:
            return column + bad
        column += w
        if u == 0:
            continue
        below = scratch[: u * w].reshape(u, w)
        np.dot(panel[w:], inverse.T, below)
        for i in range(u):
            for j in range(w):
                panel[w + i, j] = below[i, j]
        update = updates[update_start[s] : update_start[s] + u * u].reshape(u, u)
        _square(below, band, update)
        c = child[s]
        while c >= 0:
            moved = relative[relative_start[c] : relative_start[c + 1]]
            before = updates[update_start[c] : update_start[c] + height[c] ** 2].reshape(height[c], height[c])
            _take_rest(before, moved, w, update)
            c = sibling[c]
    return -1


@njit(cache=True, nogil=True)
def _square(below, band, update):
    """The lower half of update = below · belowᵀ, band by band: nothing is multiplied for the upper one."""
    u = len(below)
    if u <= BAND:
        np.dot(below, below.T, update)
        return
    for first in range(0, u, BAND):
        last = min(first + BAND, u)
        rows = band[: (last - first) * last].reshape(last - first, last)
        np.dot(below[first:last], below[:last].T, rows)
        for i in range(first, last):
            for j in range(i + 1):
                update[i, j] = rows[i - first, j]


@njit(cache=True, nogil=True)
def _take_columns(update, moved, w, panel):
    """Subtract from a panel what a child's update says about its w columns; lower half."""
    inside = _inside(moved, w)
    for i in range(len(moved)):
        target, source = panel[moved[i]], update[i]
        for j in range(min(inside, i + 1)):
            target[moved[j]] -= source[j]


@njit(cache=True, nogil=True)
def _take_rest(before, moved, w, update):
    """Add to an update what a child's update says about later columns; lower half."""
    inside = _inside(moved, w)
    for i in range(inside, len(moved)):
        target, source = update[moved[i] - w], before[i]
        for j in range(inside, i + 1):
            target[moved[j] - w] += source[j]


@njit(cache=True, nogil=True)
def _inside(moved, w):
    """How many of the sorted places lie before w."""
    count = 0
    while count < len(moved) and moved[count] < w:
        count += 1
    return count


@njit(cache=True, nogil=True)
def _triangle(panel, w, inverse):
    """Cholesky factor of the upper w x w part of a panel, in place, and its inverse; the bad pivot or −1."""
    for j in range(w):
        for i in range(j, w):
            total = panel[i, j]
            for k in range(j):
                total -= panel[i, k] * panel[j, k]
            if i > j:
                panel[i, j] = total / panel[j, j]
            elif total > 0.0:
                panel[j, j] = np.sqrt(total)
            else:
                return j
        for k in range(j + 1, w):
            panel[j, k] = 0.0
    for i in range(w):
        for j in range(w):
            inverse[i, j] = 0.0
        inverse[i, i] = 1.0 / panel[i, i]
        for k in range(i):
            for j in range(k + 1):
                inverse[i, j] -= panel[i, k] * inverse[k, j]
        for j in range(i):
            inverse[i, j] *= inverse[i, i]
    return -1


@njit(cache=True, nogil=True)
def solve(width, height, relative_start, rows, panel_start, inverse_start, panels, inverses, x):
    """x ← (L Lᵀ)⁻¹ x, columns of x (unknowns, k) one problem each; `rows` are unknowns."""
    column, count = 0, x.shape[1]
    for s in range(len(width)):
        w, u = width[s], height[s]
        inverse = inverses[inverse_start[s] : inverse_start[s] + w * w].reshape(w, w)
        below = panels[panel_start[s] + w * w : panel_start[s] + (w + u) * w].reshape(u, w)
        own, change = np.empty((w, count)), np.empty((u, count))
        np.dot(inverse, x[column : column + w], own)
        np.dot(below, own, change)
        for k in range(count):
            for i in range(w):
                x[column + i, k] = own[i, k]
            for i in range(u):
                x[rows[relative_start[s] + i], k] -= change[i, k]
        column += w
    for s in range(len(width) - 1, -1, -1):
        w, u = width[s], height[s]
        column -= w
        inverse = inverses[inverse_start[s] : inverse_start[s] + w * w].reshape(w, w)
        below = panels[panel_start[s] + w * w : panel_start[s] + (w + u) * w].reshape(u, w)
        own, later = np.empty((w, count)), np.empty((u, count))
        for k in range(count):
            for i in range(u):
                later[i, k] = x[rows[relative_start[s] + i], k]
        np.dot(below.T, later, own)
        for k in range(count):
            for i in range(w):
                own[i, k] = x[column + i, k] - own[i, k]
        np.dot(inverse.T, own, x[column : column + w])


@njit(cache=True, nogil=True)
def invert(
    width, height, parent, panel_start, inverse_start, later_start, relative_start, relative, panels, inverses, later,
    result,
):  # fmt: skip
    """Into `result`, laid out as the panels: the inverse of the matrix where L may be nonzero.

    From the last supernode to the first. With Y = L_UJ L_JJ⁻¹ and Z the inverse, Z_UJ = −Z_UU Y and
    Z_JJ = L_JJ⁻ᵀ L_JJ⁻¹ − Yᵀ Z_UJ; Z_UU, gathered from that of the parent and from its panel, waits in `later`.
    """
    for s in range(len(width) - 1, -1, -1):
        w, u = width[s], height[s]
        inverse = inverses[inverse_start[s] : inverse_start[s] + w * w].reshape(w, w)
        panel = result[panel_start[s] : panel_start[s] + (w + u) * w].reshape(w + u, w)
        np.dot(inverse.T, inverse, panel[:w])
        if u > 0:
            p = parent[s]
            w_p, u_p = width[p], height[p]
            above = result[panel_start[p] : panel_start[p] + (w_p + u_p) * w_p].reshape(w_p + u_p, w_p)
            beyond = later[later_start[p] : later_start[p] + u_p * u_p].reshape(u_p, u_p)
            mine = later[later_start[s] : later_start[s] + u * u].reshape(u, u)
            moved = relative[relative_start[s] : relative_start[s + 1]]
            _gather(above, beyond, moved, w_p, mine)
            below = panels[panel_start[s] + w * w : panel_start[s] + (w + u) * w].reshape(u, w)
            Y, own = np.empty((u, w)), np.empty((w, w))
            np.dot(below, inverse, Y)
            np.dot(mine, Y, panel[w:])
            np.dot(Y.T, panel[w:], own)
            for i in range(w):
                for j in range(w):
                    panel[i, j] += own[i, j]
            for i in range(w, w + u):
                for j in range(w):
                    panel[i, j] = -panel[i, j]


@njit(cache=True, nogil=True)
def _gather(above, beyond, moved, w, mine):
    """The inverse at rows and columns `moved` of a front: its first w columns lie in `above`, the rest in `beyond`."""
    inside = _inside(moved, w)
    for i in range(len(moved)):
        target = mine[i]
        for j in range(inside):
            target[j] = above[moved[i], moved[j]]
            mine[j, i] = target[j]
        if i >= inside:
            source = beyond[moved[i] - w]
            for j in range(inside, len(moved)):
                target[j] = source[moved[j] - w]
