"""Compiled inner loop of an occupancy grid: the cells that beams fly through and end in."""

import math

from numba import njit


@njit(cache=True)
def trace(grid, origins, ends, corner, cell, free, occupied):
    """Write `free` into the cells (row, column) between origins and ends, then `occupied` into those of the ends.

    `corner` is the lower left of the grid; cells outside it are left out. A beam is followed in steps of half a cell.
    """
    rows, columns = grid.shape
    for k in range(len(origins)):
        dx, dy = ends[k, 0] - origins[k, 0], ends[k, 1] - origins[k, 1]
        steps = int(math.ceil(2.0 * math.hypot(dx, dy) / cell))
        for s in range(steps):
            i = int(math.floor((origins[k, 1] + dy * s / steps - corner[1]) / cell))
            j = int(math.floor((origins[k, 0] + dx * s / steps - corner[0]) / cell))
            if 0 <= i < rows and 0 <= j < columns:
                grid[i, j] = free
    for k in range(len(ends)):
        i = int(math.floor((ends[k, 1] - corner[1]) / cell))
        j = int(math.floor((ends[k, 0] - corner[0]) / cell))
        if 0 <= i < rows and 0 <= j < columns:
            grid[i, j] = occupied
