"""Compiled inner loop of the degrees of freedom: how many parameters of each spline its data determine."""

import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def determined(data, prior, starts, ridge):
    """The sum over all splines of tr((D + Q + εI)⁻¹ D), D and Q being `data` and `prior` and ε `ridge`.

    Both hold the block of control points k and k + d at [k, d]; spline s has those from starts[s] up to starts[s + 1].
    By Cholesky.
    """
    total = 0.0
    for s in range(len(starts) - 1):
        first, count = starts[s], starts[s + 1] - starts[s]
        n = 2 * count
        D, L = np.zeros((n, n)), np.zeros((n, n))
        _add(D, data[first : first + count])
        _add(L, data[first : first + count])
        _add(L, prior[first : first + count])
        for i in range(n):
            for j in range(i + 1):
                value = L[i, j] + (ridge if i == j else 0.0)
                for k in range(j):
                    value -= L[i, k] * L[j, k]
                L[i, j] = math.sqrt(value) if i == j else value / L[j, j]
        x = np.empty(n)
        for c in range(n):
            for i in range(n):
                value = D[i, c]
                for k in range(i):
                    value -= L[i, k] * x[k]
                x[i] = value / L[i, i]
            for i in range(n - 1, c - 1, -1):
                value = x[i]
                for k in range(i + 1, n):
                    value -= L[k, i] * x[k]
                x[i] = value / L[i, i]
            total += x[c]
    return total


@njit(cache=True, nogil=True)
def _add(matrix, band):
    """Add the blocks of one spline to its symmetric matrix."""
    count = len(band)
    for k in range(count):
        for d in range(min(band.shape[1], count - k)):
            for a in range(2):
                for b in range(2):
                    i, j = 2 * k + a, 2 * (k + d) + b
                    matrix[i, j] += band[k, d, a, b]
                    if d > 0:
                        matrix[j, i] += band[k, d, a, b]
