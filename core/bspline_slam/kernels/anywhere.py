"""Compiled inner loop of a search through a whole map: branch and bound over ever smaller squares of places."""

import math

import numpy as np
from numba import njit


@njit(cache=True)
def pyramid(field, levels):
    """out[l, i, j] = the largest value of the field in the square of 2^l cells that begins at (i, j)."""
    rows, columns = field.shape
    out = np.empty((levels, rows, columns), field.dtype)
    out[0] = field
    for level in range(1, levels):
        half = 1 << (level - 1)
        below = out[level - 1]
        for i in range(rows):
            k = min(i + half, rows - 1)
            for j in range(columns):
                m = min(j + half, columns - 1)
                out[level, i, j] = max(max(below[i, j], below[i, m]), max(below[k, j], below[k, m]))
    return out


@njit(cache=True)
def value_at(bounds, level, cells, di, dj):
    """Mean of a level of the pyramid under points that lie in these cells, moved by (di, dj)."""
    rows, columns = bounds.shape[1], bounds.shape[2]
    size = 1 << level
    sum_ = 0.0
    for k in range(len(cells)):
        i, j = cells[k, 0] + di, cells[k, 1] + dj
        if -size < i < rows and -size < j < columns:
            sum_ += bounds[level, max(i, 0), max(j, 0)]
    return sum_ / len(cells)


@njit(cache=True)
def meets(origin, cell, i, j, size, middle, reach):
    """Whether a square of so many cells comes as near to a point as `reach` (m)."""
    x, y = origin[0] + i * cell, origin[1] + j * cell
    side = (size - 1) * cell
    dx, dy = max(x - middle[0], middle[0] - x - side, 0.0), max(y - middle[1], middle[1] - y - side, 0.0)
    return dx * dx + dy * dy <= reach * reach


@njit(cache=True)
def search_anywhere(bounds, origin, cell, points, headings, middle, reach, least, avoided, apart, apart_turn):
    """The pose (x, y, θ) with the highest mean of the field under `points`, wherever on the map, and that mean.

    `bounds` is a pyramid. Only poses at one of these headings, no farther than `reach` (m) from `middle`, and better
    than `least` are looked for, and none nearer to `avoided` than `apart` (m) and `apart_turn` (rad). Where there is
    none, the mean is `least`.
    """
    levels, rows, columns = bounds.shape
    size = 1 << (levels - 1)
    n, turns = len(points), len(headings)
    cells = np.empty((turns, n, 2), np.int64)
    for r in range(turns):
        c, s = math.cos(headings[r]), math.sin(headings[r])
        for k in range(n):
            cells[r, k, 0] = int(math.floor((c * points[k, 0] - s * points[k, 1]) / cell))
            cells[r, k, 1] = int(math.floor((s * points[k, 0] + c * points[k, 1]) / cell))
    down, across = rows // size + 1, columns // size + 1
    first = np.full(turns * down * across, -1.0)
    for a in range(down):
        for b in range(across):
            if not meets(origin, cell, a * size, b * size, size, middle, reach):
                continue
            for r in range(turns):
                first[(r * down + a) * across + b] = value_at(bounds, levels - 1, cells[r], a * size, b * size)
    best, best_r, best_i, best_j = least, 0, 0, 0
    stack = np.empty((4 * levels + 4, 3), np.int64)
    for o in np.argsort(-first):
        if first[o] <= best:
            break
        r = o // (down * across)
        turn = headings[r] - avoided[2]
        off_turn = abs(math.atan2(math.sin(turn), math.cos(turn)))
        stack[0] = (levels - 1, (o // across) % down * size, o % across * size)
        count = 1
        while count:
            count -= 1
            level, i, j = stack[count]
            if not meets(origin, cell, i, j, 1 << level, middle, reach):
                continue
            bound = value_at(bounds, level, cells[r], i, j)
            if bound <= best:
                continue
            if level == 0:
                x, y = origin[0] + i * cell - avoided[0], origin[1] + j * cell - avoided[1]
                if off_turn > apart_turn or math.sqrt(x * x + y * y) > apart:
                    best, best_r, best_i, best_j = bound, r, i, j
                continue
            half = 1 << (level - 1)
            for a in range(2):
                for b in range(2):
                    stack[count] = (level - 1, i + a * half, j + b * half)
                    count += 1
    return origin[0] + best_i * cell, origin[1] + best_j * cell, headings[best_r], best
