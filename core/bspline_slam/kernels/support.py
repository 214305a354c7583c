"""From how many places each stretch of a curve was seen."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def support(cell, pose, nearby):
    """How many different poses saw each of these beams' cells or up to `nearby` cells beside it; cells in order."""
    n = len(cell)
    out, seen = np.zeros(n, np.int64), np.zeros(pose.max() + 1, np.int64)
    count = entered = left = 0
    for k in range(n):
        if k > 0 and cell[k] == cell[k - 1]:
            out[k] = count
            continue
        while entered < n and cell[entered] <= cell[k] + nearby:
            count += seen[pose[entered]] == 0
            seen[pose[entered]] += 1
            entered += 1
        while cell[left] < cell[k] - nearby:
            seen[pose[left]] -= 1
            count -= seen[pose[left]] == 0
            left += 1
        out[k] = count
    return out
