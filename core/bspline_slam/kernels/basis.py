"""Compiled Cox–de Boor recursion: the basis functions that live at each parameter."""

import numpy as np
from numba import njit


@njit(cache=True)
def basis_rows(knots, degree, t, derivative):
    """Index of the first living basis function at each t, and the values of all degree + 1 (or their derivatives).

    Parameters outside the domain continue the polynomial of the end piece; knots[-degree - 1] is its end.
    """
    count = len(knots) - degree - 1
    last = count - 1
    while last > degree and knots[last] == knots[count]:
        last -= 1
    first = np.empty(len(t), np.int64)
    rows = np.zeros((len(t), degree + 1))
    for k in range(len(t)):
        span = min(max(np.searchsorted(knots, t[k], side="right") - 1, degree), last)
        first[k] = span - degree
        if derivative > degree:
            continue
        values = rows[k]
        values[0] = 1.0
        for p in range(1, degree + 1):
            carried = 0.0
            for r in range(p):
                low, high = knots[span - p + 1 + r], knots[span + 1 + r]
                value, width = values[r], high - low
                if p > degree - derivative:
                    slope = p * value / width
                    values[r] = carried - slope
                    carried = slope
                else:
                    values[r] = carried + (high - t[k]) / width * value
                    carried = (t[k] - low) / width * value
            values[p] = carried
    return first, rows
