"""Compiled inner loop of ray casting: which of many short chords, sorted into the cells of a grid, each ray meets
first."""

import math

import numpy as np
from numba import njit

SLACK = 1e-9
"""Slack of a chord's ends, so that no ray slips between two of them, and least distance (m) of a hit."""


@njit(cache=True)
def _entry(x, y, ux, uy, width, height):
    """Distance at which a ray enters the rectangle from (0, 0) to (width, height): 0 from inside, inf past it."""
    enter, leave = 0.0, np.inf
    for at, along, size in ((x, ux, width), (y, uy, height)):
        if along == 0.0:
            if at < 0.0 or at > size:
                return np.inf
        else:
            a, b = -at / along, (size - at) / along
            enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter if enter <= leave else np.inf


@njit(cache=True)
def _crossing(x, y, ux, uy, chord):
    """Distance along the ray to a chord (start, end), and the share of the chord there; inf where they do not meet."""
    dx, dy = chord[1, 0] - chord[0, 0], chord[1, 1] - chord[0, 1]
    turn = ux * dy - uy * dx
    if turn == 0.0:
        return np.inf, 0.0
    off_x, off_y = chord[0, 0] - x, chord[0, 1] - y
    reach = (off_x * dy - off_y * dx) / turn
    share = (off_x * uy - off_y * ux) / turn
    if reach <= SLACK or share < -SLACK or share > 1.0 + SLACK:
        return np.inf, 0.0
    return reach, share


@njit(cache=True)
def _next_border(at, along, index, cell):
    """Step of the cell index along one axis, distance of the next border and distance between borders."""
    if along == 0.0:
        return 0, np.inf, np.inf
    border = (index + 1 if along > 0.0 else index) * cell
    return (1 if along > 0.0 else -1), (border - at) / along, cell / abs(along)


@njit(cache=True)
def first_chords(origins, directions, reach, chords, start, order, corner, columns, rows, cell):
    """For each ray the first chord within `reach` (−1: none), its distance (inf) and the share of the chord there.

    The chords of cell c = row · columns + column are order[start[c] : start[c + 1]]; `corner` is the grid's lower left.
    """
    n = len(origins)
    found, distance, shares = np.full(n, -1), np.full(n, np.inf), np.zeros(n)
    for k in range(n):
        x, y, ux, uy = origins[k, 0], origins[k, 1], directions[k, 0], directions[k, 1]
        gx, gy = x - corner[0], y - corner[1]
        travelled = _entry(gx, gy, ux, uy, columns * cell, rows * cell)
        if travelled > reach:
            continue
        i = min(max(int(math.floor((gx + travelled * ux) / cell)), 0), columns - 1)
        j = min(max(int(math.floor((gy + travelled * uy) / cell)), 0), rows - 1)
        step_i, border_x, width = _next_border(gx, ux, i, cell)
        step_j, border_y, height = _next_border(gy, uy, j, cell)
        best = reach
        while travelled < best:
            for e in range(start[j * columns + i], start[j * columns + i + 1]):
                hit, share = _crossing(x, y, ux, uy, chords[order[e]])
                if hit < best:
                    best, found[k], distance[k], shares[k] = hit, order[e], hit, share
            if border_x < border_y:
                travelled, border_x, i = border_x, border_x + width, i + step_i
            else:
                travelled, border_y, j = border_y, border_y + height, j + step_j
            if i < 0 or j < 0 or i >= columns or j >= rows:
                break
    return found, distance, shares
