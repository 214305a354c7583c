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
def search_anywhere(bounds, origin, cell, points, turns, least, avoided, apart, apart_turn):
    """The pose (x, y, θ) with the highest mean of the field under `points`, wherever on the map, and that mean.

    `bounds` is a pyramid; headings are `turns` in number, all around. Only poses better than `least` are looked for,
    and none nearer to `avoided` than `apart` (m) and `apart_turn` (rad). Where there is none, the mean is `least`.
    """
    levels, rows, columns = bounds.shape
    size = 1 << (levels - 1)
    n = len(points)
    cells = np.empty((turns, n, 2), np.int64)
    for r in range(turns):
        c, s = math.cos(2.0 * math.pi * r / turns), math.sin(2.0 * math.pi * r / turns)
        for k in range(n):
            cells[r, k, 0] = int(math.floor((c * points[k, 0] - s * points[k, 1]) / cell))
            cells[r, k, 1] = int(math.floor((s * points[k, 0] + c * points[k, 1]) / cell))
    down, across = rows // size + 1, columns // size + 1
    first = np.empty(turns * down * across, np.float64)
    for r in range(turns):
        for a in range(down):
            for b in range(across):
                first[(r * down + a) * across + b] = value_at(bounds, levels - 1, cells[r], a * size, b * size)
    best, best_r, best_i, best_j = least, 0, 0, 0
    stack = np.empty((4 * levels + 4, 3), np.int64)
    for o in np.argsort(-first):
        if first[o] <= best:
            break
        r = o // (down * across)
        turn = 2.0 * math.pi * r / turns
        off_turn = abs(math.atan2(math.sin(turn - avoided[2]), math.cos(turn - avoided[2])))
        stack[0] = (levels - 1, (o // across) % down * size, o % across * size)
        count = 1
        while count:
            count -= 1
            level, i, j = stack[count]
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
    return origin[0] + best_i * cell, origin[1] + best_j * cell, 2.0 * math.pi * best_r / turns, best
