"""Compiled sums over the beams of one curve, each with the few basis functions that live at its foot."""

import numpy as np
from numba import njit


@njit(cache=True)
def information(first, basis, weighted, along, count):
    """Information of beams on (c_1x, c_1y, c_2x, …) of `count` control points: basis functions first[j] … have the
    values basis[j] at beam j, which measures along weighted[j] (normal over σ), and `along` times that beside it."""
    H = np.zeros((2 * count, 2 * count))
    for j in range(len(first)):
        n_x, n_y = weighted[j, 0], weighted[j, 1]
        xx, xy = n_x * n_x + along * along * n_y * n_y, n_x * n_y * (1.0 - along * along)
        yy = n_y * n_y + along * along * n_x * n_x
        for r in range(basis.shape[1]):
            for q in range(basis.shape[1]):
                share, a, b = basis[j, r] * basis[j, q], 2 * (first[j] + r), 2 * (first[j] + q)
                H[a, b] += share * xx
                H[a, b + 1] += share * xy
                H[a + 1, b] += share * xy
                H[a + 1, b + 1] += share * yy
    return H


@njit(cache=True)
def losses(first, basis, weighted, moves):
    """The squared distance, in σ, that these moves of the control points (n, 2) mean to each beam."""
    lost = np.empty(len(first))
    for j in range(len(first)):
        total = 0.0
        for r in range(basis.shape[1]):
            k = first[j] + r
            total += basis[j, r] * (weighted[j, 0] * moves[k, 0] + weighted[j, 1] * moves[k, 1])
        lost[j] = total * total
    return lost
