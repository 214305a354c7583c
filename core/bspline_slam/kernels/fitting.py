"""Compiled inner loops of fitting: control points by least squares, and how far points lie from samples of a curve."""

import math

import numpy as np
from numba import njit

from bspline_slam.kernels.basis import basis_rows


@njit(cache=True)
def cumulated_chords(points):
    """Length of the polygon from the first point to each point."""
    out = np.zeros(len(points))
    for j in range(1, len(points)):
        dx, dy = points[j, 0] - points[j - 1, 0], points[j, 1] - points[j - 1, 1]
        out[j] = out[j - 1] + math.sqrt(dx * dx + dy * dy)
    return out


@njit(cache=True)
def uniform_curve(points, spacing, degree, stiffness):
    """Knots and control points of a curve through ordered points: uniform knots, parameter = chord length from 0."""
    t = cumulated_chords(points)
    count = max(int(math.ceil(t[-1] / spacing)), 1) + degree
    knots = spacing * (np.arange(count + degree + 1) - degree)
    first, basis = basis_rows(knots, degree, t, 0)
    return knots, control_points(first, basis, points, np.zeros((count, 2)), 0, stiffness)


@njit(cache=True)
def control_points(first, basis, points, start, fixed, stiffness):
    """Control points by least squares with fixed parameters, second differences weighted by `stiffness`.

    `first` and `basis` (m, degree + 1) are the living basis functions of each point. The first `fixed` control points
    stay as they are in `start` (count, 2). Banded normal equations, solved by Cholesky.
    """
    count = len(start) - fixed
    band = min(max(basis.shape[1], 3), count)
    A = np.zeros((count, band))
    right = np.zeros((count, 2))
    for j in range(len(points)):
        _add_row(A, right, basis[j], first[j], points[j, 0], points[j, 1], start, fixed)
    second = np.array([1.0, -2.0, 1.0]) * stiffness
    for i in range(max(fixed - 2, 0), len(start) - 2):
        _add_row(A, right, second, i, 0.0, 0.0, start, fixed)
    _solve_banded(A, right)
    out = start.copy()
    out[fixed:] = right
    return out


@njit(cache=True)
def _add_row(A, right, row, first, x, y, start, fixed):
    """One row of the least squares: row · c[first …] = (x, y)."""
    for r in range(len(row)):
        if first + r < fixed:
            x -= row[r] * start[first + r, 0]
            y -= row[r] * start[first + r, 1]
    for r in range(max(fixed - first, 0), len(row)):
        i = first + r - fixed
        right[i, 0] += row[r] * x
        right[i, 1] += row[r] * y
        for s in range(max(fixed - first, 0), r + 1):
            A[i, r - s] += row[r] * row[s]


@njit(cache=True)
def _solve_banded(A, right):
    """Solve in place; A[i, d] holds the entry (i, i − d) of a symmetric positive definite matrix."""
    count, band = A.shape
    for i in range(count):
        A[i, 0] += 1e-12
        for d in range(min(band - 1, i), -1, -1):
            j = i - d
            total = A[i, d]
            for k in range(max(0, i - band + 1, j - band + 1), j):
                total -= A[i, i - k] * A[j, j - k]
            A[i, d] = math.sqrt(total) if d == 0 else total / A[j, 0]
    for c in range(2):
        for i in range(count):
            for k in range(max(0, i - band + 1), i):
                right[i, c] -= A[i, i - k] * right[k, c]
            right[i, c] /= A[i, 0]
        for i in range(count - 1, -1, -1):
            for k in range(i + 1, min(count, i + band)):
                right[i, c] -= A[k, k - i] * right[k, c]
            right[i, c] /= A[i, 0]


@njit(cache=True)
def largest_distance(points, samples):
    """The largest distance of a point to the nearest sample."""
    largest = 0.0
    for j in range(len(points)):
        nearest = np.inf
        for k in range(len(samples)):
            dx, dy = points[j, 0] - samples[k, 0], points[j, 1] - samples[k, 1]
            nearest = min(nearest, dx * dx + dy * dy)
        largest = max(largest, nearest)
    return math.sqrt(largest)


@njit(cache=True)
def sparse_gaps(points, gap, ratio):
    """After which points (seen from the origin) the next lies farther off than `gap` and than `ratio` times what a wall
    facing the origin would give."""
    out = np.empty(len(points), np.int64)
    n = 0
    for j in range(len(points) - 1):
        dx, dy = points[j + 1, 0] - points[j, 0], points[j + 1, 1] - points[j, 1]
        length = math.sqrt(dx * dx + dy * dy)
        if length <= gap:
            continue
        reach = max(math.sqrt(points[j, 0] * points[j, 0] + points[j, 1] * points[j, 1]), 1e-9)
        across = abs(points[j, 0] * points[j + 1, 1] - points[j, 1] * points[j + 1, 0])
        if length > ratio * across / reach:
            out[n] = j
            n += 1
    return out[:n]
