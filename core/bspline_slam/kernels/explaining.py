"""Compiled inner loops of association: which splines explain a segment, and where it is cut between them."""

import math

import numpy as np
from numba import njit

from bspline_slam.kernels.matching import bucket_points, facing_candidates


@njit(cache=True, nogil=True)
def near_splines(points, normals, ids, first, last, rows, bucket, gate, along, agreement, most):
    """Of each point up to `most` splines near it, nearest first: id (−1: none), parameter, distance across.

    Spline ids[s] has the samples first[s] … last[s] − 1 in `rows` (x, y, normal, parameter). A sample speaks for a
    point when it lies within `gate` across the curve and `along` it, and the normals agree.
    """
    total = 0
    for s in range(len(ids)):
        total += last[s] - first[s]
    samples, across, t = np.empty((total, 2)), np.empty((total, 2)), np.empty(total)
    owner = np.empty(total, np.int64)
    n = 0
    for s in range(len(ids)):
        for k in range(first[s], last[s]):
            samples[n, 0], samples[n, 1], across[n, 0], across[n, 1] = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
            t[n], owner[n] = rows[k, 4], ids[s]
            n += 1
    origin, shape = np.empty(2), np.empty(2, np.int64)
    for d in range(2):
        origin[d] = samples[:, d].min() - bucket
        shape[d] = int(math.ceil((samples[:, d].max() - origin[d]) / bucket)) + 1
    start, order = bucket_points(samples, origin, shape, bucket)
    found = facing_candidates(
        points, normals, samples, across, owner, start, order, origin, shape, bucket, max(gate, along), agreement, most
    )
    m = len(points)
    spline, at, off = np.full((m, most), -1), np.zeros((m, most)), np.zeros((m, most))
    for j in range(m):
        for c in range(most):
            k = found[j, c]
            if k < 0:
                break
            dx, dy = points[j, 0] - samples[k, 0], points[j, 1] - samples[k, 1]
            aside = dx * across[k, 1] - dy * across[k, 0]
            off[j, c], at[j, c] = dx * across[k, 0] + dy * across[k, 1], t[k] + aside
            if abs(off[j, c]) < gate and abs(aside) < along:
                spline[j, c] = owner[k]
    return spline, at, off


@njit(cache=True)
def candidates(spline, across, a, b):
    """Splines near points a … b − 1, with RMS distance and the share that each explains: most first, shares in steps of
    a tenth, ties by distance."""
    ids, counts, squares = tally(spline, across, a, b)
    share, distance = counts / (b - a), np.sqrt(squares / np.maximum(counts, 1))
    order = np.argsort(distance, kind="mergesort")
    order = order[np.argsort(-np.floor(10.0 * share[order] + 0.5), kind="mergesort")]
    return ids[order], distance[order], share[order]


@njit(cache=True)
def reached(spline, t, a, b, which):
    """Least and largest parameter of `which` at the points a … b − 1 that it explains; NaN where there is none."""
    low, high = np.inf, -np.inf
    for j in range(a, b):
        for c in range(spline.shape[1]):
            if spline[j, c] == which:
                low, high = min(low, t[j, c]), max(high, t[j, c])
    return (low, high) if low <= high else (np.nan, np.nan)


@njit(cache=True)
def tally(spline, across, a, b):
    """Splines near points a … b − 1, by id, with how many points each explains and the sum of squared distances."""
    most = (b - a) * spline.shape[1]
    ids = np.empty(most, np.int64)
    counts = np.zeros(most, np.int64)
    squares = np.zeros(most)
    n = 0
    for j in range(a, b):
        for c in range(spline.shape[1]):
            if spline[j, c] < 0:
                continue
            k = 0
            while k < n and ids[k] != spline[j, c]:
                k += 1
            if k == n:
                ids[n] = spline[j, c]
                n += 1
            counts[k] += 1
            squares[k] += across[j, c] * across[j, c]
    order = np.argsort(ids[:n])
    return ids[:n][order], counts[:n][order], squares[:n][order]


@njit(cache=True)
def best_of(spline, across, a, b, least, nearly):
    """The spline that explains most of points a … b − 1; among those that explain `nearly` (share) as many the closest;
    −1 when none explains `least` of them."""
    ids, counts, squares = tally(spline, across, a, b)
    if len(ids) == 0 or counts.max() < least:
        return -1
    enough = nearly * counts.max()
    best, smallest = -1, np.inf
    for k in range(len(ids)):
        if counts[k] >= enough and squares[k] / counts[k] < smallest:
            best, smallest = ids[k], squares[k] / counts[k]
    return best


@njit(cache=True)
def longest_run(spline, which, a, b, hole):
    """Longest stretch of points a … b − 1 that `which` explains, holes of up to `hole` points bridged: start, end, and
    how many of its points are explained."""
    best_start, best_end, best_count = a, a, 0
    start, last, count = -1, -1, 0
    for j in range(a, b):
        explained = False
        for c in range(spline.shape[1]):
            explained = explained or spline[j, c] == which
        if not explained:
            continue
        if start < 0 or j - last > hole + 1:
            start, count = j, 0
        last = j
        count += 1
        if last + 1 - start > best_end - best_start:
            best_start, best_end, best_count = start, last + 1, count
        elif start == best_start:
            best_count = count
    return best_start, best_end, best_count


@njit(cache=True)
def pieces(spline, across, least, nearly, hole):
    """Rows (a, b, id or −1), in order and without gaps: what explains most is cut out first, then the same is done for
    what is left on both sides of it; neighbours that belong to the same are one."""
    m = len(spline)
    owner = np.full(m, -1, np.int64)
    waiting = [(0, m)]
    while len(waiting) > 0:
        a, b = waiting.pop()
        if a >= b:
            continue
        best = best_of(spline, across, a, b, least, nearly)
        if best < 0:
            continue
        start, end, count = longest_run(spline, best, a, b, hole)
        if count < least:
            continue
        owner[start:end] = best
        waiting.append((a, start))
        waiting.append((end, b))
    out = np.empty((m, 3), np.int64)
    n = 0
    for j in range(m):
        if n > 0 and out[n - 1, 2] == owner[j]:
            out[n - 1, 1] = j + 1
        else:
            out[n, 0], out[n, 1], out[n, 2] = j, j + 1, owner[j]
            n += 1
    return out[:n]
