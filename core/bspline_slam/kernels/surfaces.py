"""Compiled inner loops over the beams of one scan: their ends, where the surface breaks, and its normals."""

import math

import numpy as np
from numba import njit

WITHIN = 0.1
"""Points so near (m) always count for a normal."""
ONE_WAY = 0.05
"""Share of all walls that must stop a motion in every direction."""


@njit(cache=True)
def beam_ends(ranges, bearings, nearest, farthest, x, y, heading):
    """Beams that hit something between `nearest` and `farthest`, and their ends (m, 2); sensor at (x, y, heading)."""
    beams = np.empty(len(ranges), np.int64)
    points = np.empty((len(ranges), 2))
    m = 0
    for k in range(len(ranges)):
        reach = ranges[k]
        if nearest < reach < farthest:
            beams[m] = k
            points[m, 0] = x + reach * math.cos(bearings[k] + heading)
            points[m, 1] = y + reach * math.sin(bearings[k] + heading)
            m += 1
    return beams[:m], points[:m]


@njit(cache=True)
def breakpoints(ranges, bearings, incidence, allowance, leap, leap_ratio, widest):
    """Whether the surface breaks between neighbouring kept beams (Borges & Aldon 2004, eq. 8, with an allowance, m), or
    leaps: a gap of more than `leap` and `leap_ratio` times those beside it; beams `widest` (rad) apart always break."""
    m = len(ranges)
    gap = np.empty(m - 1)
    out = np.empty(m - 1, np.bool_)
    for j in range(m - 1):
        turn = bearings[j + 1] - bearings[j]
        a, b = ranges[j], ranges[j + 1]
        gap[j] = math.sqrt(a * a + b * b - 2.0 * a * b * math.cos(turn))
        flattest = max(incidence - min(turn, 0.8 * incidence), 0.02)
        allowed = min(a, b) * math.sin(turn) / math.sin(flattest) + allowance
        out[j] = gap[j] > allowed or turn > widest
    for j in range(m - 1):
        around = max(gap[max(j - 1, 0)], gap[min(j + 1, m - 2)])
        if gap[j] > leap and gap[j] > leap_ratio * around:
            out[j] = True
    return out


@njit(cache=True)
def mixed_ends(points, cuts, breaks, limit, beside, least):
    """How many end points (0 or 1) each piece points[cuts[k]:cuts[k + 1]] loses at its start and at its end (k, 2).

    A point is lost where the surface `breaks` at that cut and the point lies more than `limit` (m) off the line that
    leads through the `beside` points next to it; no piece is left with fewer than `least` points.
    """
    out = np.zeros((len(cuts) - 1, 2), np.int64)
    for k in range(len(cuts) - 1):
        a, b = cuts[k], cuts[k + 1] - 1
        for side, first, way in ((0, a, 1), (1, b, -1)):
            left = b - a + 1 - out[k, 0]
            asked = breaks[k + side] and left > least
            if asked and _off_line(points, first, way, min(beside, left - 1)) > limit:
                out[k, side] = 1
    return out


@njit(cache=True)
def _off_line(points, end, way, beside):
    """Distance (m) of a point from the line along the `beside` points that follow it that `way`."""
    near, far = end + way, end + way * beside
    along_x, along_y = points[far, 0] - points[near, 0], points[far, 1] - points[near, 1]
    length = math.sqrt(along_x * along_x + along_y * along_y)
    if length == 0.0:
        return 0.0
    x, y = 0.0, 0.0
    for step in range(1, beside + 1):
        x += points[end + way * step, 0] / beside
        y += points[end + way * step, 1] / beside
    return abs(along_x * (points[end, 1] - y) - along_y * (points[end, 0] - x)) / length


@njit(cache=True)
def normals_of_runs(points, breaks, x, y, reach, turn_limit):
    """Unit normals towards (x, y) by principal axes of the neighbours on the same surface: up to `reach` each side, and
    more where these lie so close together that noise would turn the axes (WITHIN, m).

    `breaks` says whether the surface breaks after each point but the last. A normal is (0, 0) where fewer than three
    points stand on one surface or they do not lie along a line.
    """
    n = len(points)
    out = np.zeros((n, 2))
    for i in range(n):
        first = i
        while first > 0 and not breaks[first - 1] and (first > i - reach or _within(points, first - 1, i)):
            first -= 1
        last = i
        while last < n - 1 and not breaks[last] and (last < i + reach or _within(points, last + 1, i)):
            last += 1
        count = last + 1 - first
        if count < 3:
            continue
        mx = my = 0.0
        for j in range(first, last + 1):
            mx += points[j, 0]
            my += points[j, 1]
        mx /= count
        my /= count
        xx = xy = yy = 0.0
        for j in range(first, last + 1):
            dx = points[j, 0] - mx
            dy = points[j, 1] - my
            xx += dx * dx
            xy += dx * dy
            yy += dy * dy
        spread = math.sqrt((xx - yy) ** 2 + 4.0 * xy * xy)
        large, small = 0.5 * (xx + yy + spread), 0.5 * (xx + yy - spread)
        if small > turn_limit * large:
            continue
        angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
        nx, ny = -math.sin(angle), math.cos(angle)
        if nx * (points[i, 0] - x) + ny * (points[i, 1] - y) > 0.0:
            nx, ny = -nx, -ny
        out[i, 0] = nx
        out[i, 1] = ny
    return out


@njit(cache=True)
def _within(points, j, i):
    dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
    return dx * dx + dy * dy < WITHIN * WITHIN


@njit(cache=True)
def chord_normals(points, sizes, reach):
    """Unit normals of several polygons, `sizes[k]` points each: the chord over ±`reach` points turned left."""
    out = np.zeros((len(points), 2))
    first = 0
    for size in sizes:
        last = first + size - 1
        for k in range(first, last + 1):
            a, b = max(k - reach, first), min(k + reach, last)
            dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
            length = max(math.sqrt(dx * dx + dy * dy), 1e-12)
            out[k, 0], out[k, 1] = -dy / length, dx / length
        first = last + 1
    return out


@njit(cache=True, nogil=True)
def points_with_normals(
    ranges, bearings, nearest, farthest, x, y, heading,
    incidence, allowance, leap, leap_ratio, widest, reach, turn_limit, enough,
):  # fmt: skip
    """`beam_ends` with the `normals_of_runs` between their `breakpoints`, in one call. Beams beyond `enough` (m) are
    left out where those before it say where the sensor is."""
    args = (x, y, heading, incidence, allowance, leap, leap_ratio, widest, reach, turn_limit)
    points, normals = _with_normals(ranges, bearings, nearest, min(enough, farthest), *args)
    if enough >= farthest or pinned(normals):
        return points, normals
    return _with_normals(ranges, bearings, nearest, farthest, *args)


@njit(cache=True)
def pinned(normals):
    """Whether walls with these normals stop a motion in any direction: ONE_WAY of them face each."""
    xx = xy = yy = 0.0
    for k in range(len(normals)):
        xx += normals[k, 0] * normals[k, 0]
        xy += normals[k, 0] * normals[k, 1]
        yy += normals[k, 1] * normals[k, 1]
    return 0.5 * (xx + yy - math.sqrt((xx - yy) ** 2 + 4.0 * xy * xy)) > ONE_WAY * len(normals)


@njit(cache=True)
def _with_normals(
    ranges, bearings, nearest, farthest, x, y, heading,
    incidence, allowance, leap, leap_ratio, widest, reach, turn_limit,
):  # fmt: skip
    beams, points = beam_ends(ranges, bearings, nearest, farthest, x, y, heading)
    if len(beams) < 2:
        return points, np.zeros_like(points)
    breaks = breakpoints(ranges[beams], bearings[beams], incidence, allowance, leap, leap_ratio, widest)
    return points, normals_of_runs(points, breaks, x, y, reach, turn_limit)
