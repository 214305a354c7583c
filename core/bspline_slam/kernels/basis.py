"""Compiled Cox–de Boor recursion: the basis functions that live at each parameter."""

import math

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


@njit(cache=True)
def curve_points(knots, degree, control_points, t, derivative):
    """Points of a curve at each t, or its derivatives."""
    first, rows = basis_rows(knots, degree, t, derivative)
    out = np.zeros((len(t), 2))
    for k in range(len(t)):
        for r in range(degree + 1):
            out[k, 0] += rows[k, r] * control_points[first[k] + r, 0]
            out[k, 1] += rows[k, r] * control_points[first[k] + r, 1]
    return out


@njit(cache=True)
def samples(knots, degree, control_points, low, high, spacing):
    """Parameters, points and unit normals (the tangent turned left) of a stretch of curve, evenly spaced along it, at
    most about `spacing` apart; lengths are those of chords over a quarter of a knot span."""
    count = len(control_points)
    coarse = np.empty(4 * (count + 1) + 1)
    n, at = 0, low
    for k in range(degree, count + 1):
        end = min(max(knots[k], low), high)
        if end > at:
            for quarter in range(4):
                coarse[n] = at + (end - at) * (quarter / 4)
                n += 1
            at = end
    if high > at:
        for quarter in range(4):
            coarse[n] = at + (high - at) * (quarter / 4)
            n += 1
    coarse[n] = high
    points = curve_points(knots, degree, control_points, coarse[: n + 1], 0)
    length = np.zeros(n + 1)
    for k in range(n):
        dx, dy = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        length[k + 1] = length[k] + math.sqrt(dx * dx + dy * dy)
    pieces = max(int(math.ceil(length[n] / spacing)), 1)
    t = np.interp(np.linspace(0.0, length[n], pieces + 1), length, coarse[: n + 1])
    tangents = curve_points(knots, degree, control_points, t, 1)
    normals = np.empty_like(tangents)
    for k in range(len(t)):
        speed = max(math.sqrt(tangents[k, 0] * tangents[k, 0] + tangents[k, 1] * tangents[k, 1]), 1e-12)
        normals[k, 0], normals[k, 1] = -tangents[k, 1] / speed, tangents[k, 0] / speed
    return t, curve_points(knots, degree, control_points, t, 0), normals
