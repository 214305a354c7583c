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
def _at(t, degree, count, knots, control_points, values, slopes):
    """Knot span, point and derivative of a curve at t; basis functions and their slopes into `values`, `slopes`."""
    span = _span(knots, degree, count, t)
    _basis(knots, degree, span, t, values, slopes)
    px = py = dx = dy = 0.0
    for r in range(degree + 1):
        cx, cy = control_points[span - degree + r, 0], control_points[span - degree + r, 1]
        px += values[r] * cx
        py += values[r] * cy
        dx += slopes[r] * cx
        dy += slopes[r] * cy
    return span, px, py, dx, dy


@njit(cache=True, nogil=True)
def feet(
    c_first, c_last, degrees, knot_start, all_knots, point_start, all_points, spans, cuts, frames, seen_from, points,
    directions, spacing, t_out, first, basis, normals, across, beside, facing,
):  # fmt: skip
    """The foot of the end of each beam on its curve: parameter inside the curve's span, first basis index (of its own
    curve), basis values, unit normal (tangent turned left), distance along the normal, and beside it, and the cosine
    between normal and way back; into `t_out` … `facing`, of curves c_first … c_last − 1.

    Curve c has the beams cuts[c] … cuts[c + 1] − 1, its knots begin at knot_start[c] and its control points at
    point_start[c]. Beam k is seen from frames[seen_from[k]] = (x, y, cos θ, sin θ). Starts at the nearest of samples
    `spacing` of parameter apart and goes on by at most six Gauss–Newton steps.
    """
    values, slopes = np.empty(basis.shape[1]), np.empty(basis.shape[1])
    for c in range(c_first, c_last):
        if cuts[c] == cuts[c + 1]:
            continue
        degree, count = degrees[c], point_start[c + 1] - point_start[c]
        knots = all_knots[knot_start[c] : knot_start[c + 1]]
        control_points = all_points[point_start[c] : point_start[c + 1]]
        start, end = spans[c, 0], spans[c, 1]
        pieces = max(int(math.ceil((end - start) / spacing)), 1)
        samples = np.empty((pieces + 1, 2))
        for s in range(pieces + 1):
            _, samples[s, 0], samples[s, 1], _, _ = _at(
                start + (end - start) * s / pieces, degree, count, knots, control_points, values, slopes
            )
        for k in range(cuts[c], cuts[c + 1]):
            from_x, from_y, turn_c, turn_s = frames[seen_from[k]]
            x = from_x + turn_c * points[k, 0] - turn_s * points[k, 1]
            y = from_y + turn_s * points[k, 0] + turn_c * points[k, 1]
            best, nearest = 1e18, 0
            for s in range(pieces + 1):
                dx, dy = samples[s, 0] - x, samples[s, 1] - y
                d = dx * dx + dy * dy
                if d < best:
                    best, nearest = d, s
            t = start + (end - start) * nearest / pieces
            span, px, py, dx, dy = _at(t, degree, count, knots, control_points, values, slopes)
            for _ in range(6):
                speed = dx * dx + dy * dy + 1e-18
                moved = min(max(t - ((px - x) * dx + (py - y) * dy) / speed, start), end)
                if abs(moved - t) * math.sqrt(speed) < 1e-6:
                    break
                t = moved
                span, px, py, dx, dy = _at(t, degree, count, knots, control_points, values, slopes)
            length = math.sqrt(dx * dx + dy * dy + 1e-18)
            t_out[k], first[k] = t, span - degree
            for r in range(degree + 1):
                basis[k, r] = values[r]
            normals[k, 0], normals[k, 1] = -dy / length, dx / length
            across[k] = (x - px) * normals[k, 0] + (y - py) * normals[k, 1]
            beside[k] = abs((x - px) * normals[k, 1] - (y - py) * normals[k, 0])
            back_x = turn_s * directions[k, 1] - turn_c * directions[k, 0]
            back_y = -turn_s * directions[k, 0] - turn_c * directions[k, 1]
            facing[k] = back_x * normals[k, 0] + back_y * normals[k, 1]


@njit(cache=True)
def greville(degrees, knot_start, all_knots, point_start, all_points):
    """Of each control point its Greville abscissa, and the unit tangent of its curve there."""
    abscissae, tangents = np.empty(len(all_points)), np.empty((len(all_points), 2))
    for c in range(len(degrees)):
        degree, count = degrees[c], point_start[c + 1] - point_start[c]
        knots = all_knots[knot_start[c] : knot_start[c + 1]]
        control_points = all_points[point_start[c] : point_start[c + 1]]
        values, slopes = np.empty(degree + 1), np.empty(degree + 1)
        for k in range(count):
            t = knots[k + 1 : k + degree + 1].mean()
            inside = min(max(t, knots[degree]), knots[count])
            _, _, _, dx, dy = _at(inside, degree, count, knots, control_points, values, slopes)
            length = max(math.sqrt(dx * dx + dy * dy), 1e-12)
            at = point_start[c] + k
            abscissae[at], tangents[at, 0], tangents[at, 1] = t, dx / length, dy / length
    return abscissae, tangents


@njit(cache=True)
def points_at(t, degrees, knot_start, all_knots, point_start, all_points):
    """The point of each curve at its parameter in `t`."""
    points = np.empty((len(t), 2))
    for c in range(len(t)):
        degree, count = degrees[c], point_start[c + 1] - point_start[c]
        knots = all_knots[knot_start[c] : knot_start[c + 1]]
        control_points = all_points[point_start[c] : point_start[c + 1]]
        values, slopes = np.empty(degree + 1), np.empty(degree + 1)
        _, points[c, 0], points[c, 1], _, _ = _at(t[c], degree, count, knots, control_points, values, slopes)
    return points


@njit(cache=True)
def piece_sizes(cuts, orders, first):
    """Of each piece: its first control point, rows and columns of its compressed observation."""
    pieces = len(orders)
    low, rows, columns = np.empty(pieces, np.int64), np.empty(pieces, np.int64), np.empty(pieces, np.int64)
    for p in range(pieces):
        a, b = first[cuts[p] : cuts[p + 1]].min(), first[cuts[p] : cuts[p + 1]].max()
        low[p], columns[p] = a, 2 * (b - a + orders[p])
        rows[p] = min(cuts[p + 1] - cuts[p], columns[p])
    return low, rows, columns


@njit(cache=True, nogil=True)
def compressed_pieces(cuts, orders, first, basis, normals, right, weight, low, rows, columns):
    """Triangular (R, Qᵀb, constant) of the rows w_j·(β_i(t_j) n_j | n_j·p_j) of each piece over the control points that
    it touches, flat one after another.

    Householder QR of the beams cuts[p] … cuts[p + 1] − 1; `first` are basis indices, `right` = n_j·p_j; sizes as
    `piece_sizes` tells them.
    """
    A, b, constants = np.empty((rows * columns).sum()), np.empty(rows.sum()), np.zeros(len(rows))
    a_at, b_at = 0, 0
    for p in range(len(rows)):
        n, width, start = cuts[p + 1] - cuts[p], columns[p], cuts[p]
        M = np.zeros((n, width + 1))
        for j in range(n):
            for r in range(orders[p]):
                c = 2 * (first[start + j] - low[p] + r)
                M[j, c] = weight[start + j] * basis[start + j, r] * normals[start + j, 0]
                M[j, c + 1] = weight[start + j] * basis[start + j, r] * normals[start + j, 1]
            M[j, width] = weight[start + j] * right[start + j]
        if n > width:
            constants[p] = _triangular(M)
        for i in range(rows[p]):
            for c in range(width):
                A[a_at + i * width + c] = M[i, c]
            b[b_at + i] = M[i, width]
        a_at += rows[p] * width
        b_at += rows[p]
    return A, b, constants


@njit(cache=True)
def _triangular(M):
    """Householder QR of (A | b), more rows than columns, in place: R and Qᵀb on top; what is left of ‖b‖² below."""
    n, columns = len(M), M.shape[1] - 1
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
    return constant
