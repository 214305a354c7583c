"""Compiled sums over places on one curve, each with the few basis functions that live there."""

import numpy as np
from numba import njit


@njit(cache=True)
def gathered(t, normals, weight, low, width, along):
    """Beams at parameters t gathered in cells `width` wide from `low` on. Of each cell that has any: their mean
    parameter, and the sums (xx, xy, yy) of what they measure along their normals, with weights 1/σ, first alone and
    then with `along` times that beside them."""
    cells = 1
    for j in range(len(t)):
        cells = max(cells, int((t[j] - low) / width) + 1)
    total, count, across, held = np.zeros(cells), np.zeros(cells), np.zeros((cells, 3)), np.zeros((cells, 3))
    for j in range(len(t)):
        k, w = max(int((t[j] - low) / width), 0), weight[j] * weight[j]
        x, y = normals[j, 0], normals[j, 1]
        total[k] += t[j]
        count[k] += 1
        across[k, 0] += w * x * x
        across[k, 1] += w * x * y
        across[k, 2] += w * y * y
        held[k, 0] += w * (x * x + along * along * y * y)
        held[k, 1] += w * x * y * (1.0 - along * along)
        held[k, 2] += w * (y * y + along * along * x * x)
    some = count > 0
    return total[some] / count[some], across[some], held[some]


@njit(cache=True)
def normal_equations(first, basis, weight, points, count):
    """H and g of H c = g for `count` control points (x, y of each in turn) of the curve nearest to these points:
    basis functions first[j] … have the values basis[j] at point j, which counts by weight[j] (xx, xy, yy)."""
    H, g = np.zeros((2 * count, 2 * count)), np.zeros(2 * count)
    for j in range(len(first)):
        xx, xy, yy = weight[j, 0], weight[j, 1], weight[j, 2]
        x, y = xx * points[j, 0] + xy * points[j, 1], xy * points[j, 0] + yy * points[j, 1]
        for r in range(basis.shape[1]):
            a = 2 * (first[j] + r)
            g[a] += basis[j, r] * x
            g[a + 1] += basis[j, r] * y
            for q in range(basis.shape[1]):
                share, b = basis[j, r] * basis[j, q], 2 * (first[j] + q)
                H[a, b] += share * xx
                H[a, b + 1] += share * xy
                H[a + 1, b] += share * xy
                H[a + 1, b + 1] += share * yy
    return H, g


@njit(cache=True)
def losses(first, basis, weight, points, control_points):
    """How much farther from each point a curve is than none, squared and weighted as there."""
    lost = np.empty(len(first))
    for j in range(len(first)):
        x, y = -points[j, 0], -points[j, 1]
        for r in range(basis.shape[1]):
            x += basis[j, r] * control_points[first[j] + r, 0]
            y += basis[j, r] * control_points[first[j] + r, 1]
        lost[j] = weight[j, 0] * x * x + 2.0 * weight[j, 1] * x * y + weight[j, 2] * y * y
    return lost
