"""Compiled inner loops on curves: foot points, and the whitened rows of observations compressed by QR."""

import math

import numpy as np
from numba import njit


@njit(cache=True)
def _basis(knots, degree, span, t, values, slopes):
    """The degree + 1 basis functions on one knot span and their first derivatives, into `values` and `slopes`."""
    values[0] = 1.0
    for p in range(1, degree + 1):
        if p == degree:
            for r in range(degree + 1):
                slopes[r] = 0.0
            for r in range(degree):
                width = knots[span + 1 + r] - knots[span - degree + 1 + r]
                slope = degree * values[r] / width
                slopes[r] -= slope
                slopes[r + 1] += slope
        carried = 0.0
        for r in range(p):
            low = knots[span - p + 1 + r]
            high = knots[span + 1 + r]
            share = values[r] / (high - low)
            values[r] = carried + (high - t) * share
            carried = (t - low) * share
        values[p] = carried


@njit(cache=True)
def _span(knots, degree, count, t):
    """Index of the knot span of the domain that holds t."""
    low, high = degree, count - 1
    while low < high:
        middle = (low + high + 1) // 2
        if knots[middle] <= t:
            low = middle
        else:
            high = middle - 1
    while low > degree and knots[low] == knots[low + 1]:
        low -= 1
    return low


@njit(cache=True)
def feet(knots, degree, control_points, samples_t, samples, points, start, end):
    """Foot parameter in [start, end], first basis index, basis values, unit normal (tangent turned left) of each point.

    Starts at the nearest of the ordered samples and goes on by at most six Gauss–Newton steps.
    """
    n = len(points)
    count = len(control_points)
    t_out = np.empty(n)
    first = np.empty(n, np.int64)
    basis = np.empty((n, degree + 1))
    normals = np.empty((n, 2))
    values = np.empty(degree + 1)
    slopes = np.empty(degree + 1)
    for k in range(n):
        x, y = points[k, 0], points[k, 1]
        best = 1e18
        t = samples_t[0]
        for s in range(len(samples_t)):
            dx, dy = samples[s, 0] - x, samples[s, 1] - y
            d = dx * dx + dy * dy
            if d < best:
                best = d
                t = samples_t[s]
        t = min(max(t, start), end)
        span, speed, dx, dy = degree, 1.0, 1.0, 0.0
        for it in range(7):
            span = _span(knots, degree, count, t)
            _basis(knots, degree, span, t, values, slopes)
            px = py = dx = dy = 0.0
            for r in range(degree + 1):
                cx, cy = control_points[span - degree + r, 0], control_points[span - degree + r, 1]
                px += values[r] * cx
                py += values[r] * cy
                dx += slopes[r] * cx
                dy += slopes[r] * cy
            speed = dx * dx + dy * dy + 1e-18
            moved = min(max(t - ((px - x) * dx + (py - y) * dy) / speed, start), end)
            if it == 6 or abs(moved - t) * math.sqrt(speed) < 1e-6:
                break
            t = moved
        length = math.sqrt(speed)
        t_out[k] = t
        first[k] = span - degree
        for r in range(degree + 1):
            basis[k, r] = values[r]
        normals[k, 0] = -dy / length
        normals[k, 1] = dx / length
    return t_out, first, basis, normals


@njit(cache=True)
def compressed_rows(first, basis, normals, right, weight):
    """Triangular (R, Qᵀb, constant) of the rows w_j·(β_i(t_j) n_j | n_j·p_j) over the control points they touch.

    Householder QR of the rows of one observation; `first` are basis indices, `right` = n_j·p_j.
    Returns the first control point, R (r, 2m), b (r,) and the constant.
    """
    n, k = basis.shape
    low = first.min()
    width = first.max() - low + k
    columns = 2 * width
    M = np.zeros((n, columns + 1))
    for j in range(n):
        for r in range(k):
            c = 2 * (first[j] - low + r)
            M[j, c] = weight[j] * basis[j, r] * normals[j, 0]
            M[j, c + 1] = weight[j] * basis[j, r] * normals[j, 1]
        M[j, columns] = weight[j] * right[j]
    if n <= columns:
        return low, M[:, :columns].copy(), M[:, columns].copy(), 0.0
    for c in range(columns):
        norm = 0.0
        for j in range(c, n):
            norm += M[j, c] * M[j, c]
        norm = math.sqrt(norm)
        if norm == 0.0:
            continue
        alpha = -norm if M[c, c] > 0 else norm
        v0 = M[c, c] - alpha
        scale = 0.0
        for j in range(c + 1, n):
            scale += M[j, c] * M[j, c]
        scale += v0 * v0
        if scale == 0.0:
            continue
        for d in range(c + 1, columns + 1):
            dot = v0 * M[c, d]
            for j in range(c + 1, n):
                dot += M[j, c] * M[j, d]
            dot *= 2.0 / scale
            M[c, d] -= dot * v0
            for j in range(c + 1, n):
                M[j, d] -= dot * M[j, c]
        M[c, c] = alpha
        for j in range(c + 1, n):
            M[j, c] = 0.0
    constant = 0.0
    for j in range(columns, n):
        constant += M[j, columns] * M[j, columns]
    return low, M[:columns, :columns].copy(), M[:columns, columns].copy(), constant
