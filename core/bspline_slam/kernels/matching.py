"""Compiled inner loops of scan matching: likelihood field, branch and bound, point-to-line Gauss–Newton."""

import math

import numpy as np
from numba import njit

STILL = 1e-5
"""A step of Gauss–Newton below this (m and rad) changes nothing that anybody could see."""
APART, RIVAL = 0.3, 0.9
"""A place so far along a wall (m) is another one, and as good when its correlation is such a share of the best."""
OPEN = 1e-3
"""Squared error of a normal (rad²): that of a few neighbouring beams."""
FILLED, FLAT, LEAP = 0.1, 0.1, 1.6
"""Points on a surface are never farther apart than this (m), where it is flat (sine of an angle) and the gap between
beams is no leap (ratio)."""


@njit(cache=True, nogil=True)
def thin(points, cell):
    """Indices of points such that no two kept neighbours in order are nearer than `cell`."""
    keep = np.empty(len(points), np.int64)
    count = 0
    x = y = 1e18
    for i in range(len(points)):
        dx = points[i, 0] - x
        dy = points[i, 1] - y
        if dx * dx + dy * dy >= cell * cell:
            keep[count] = i
            count += 1
            x, y = points[i, 0], points[i, 1]
    return keep[:count]


@njit(cache=True, nogil=True)
def likelihood_field(points, cell, sigma, margin):
    """Field of exp(−d²/2σ²) of the distance to the nearest point, 0 beyond 2.5 σ, and the corner where it begins,
    `margin` (m) before the first point; single precision throughout."""
    origin, shape = np.empty(2), np.empty(2, np.int64)
    for d in range(2):
        origin[d] = points[:, d].min() - margin
        shape[d] = int(math.ceil((points[:, d].max() + margin - origin[d]) / cell))
    reach = int(math.ceil(2.5 * sigma / cell))
    nothing = np.float32(1e9)
    nearest = np.full((shape[0], shape[1]), nothing)
    half = np.float32(0.5)
    for k in range(len(points)):
        fx = np.float32((points[k, 0] - origin[0]) / cell)
        fy = np.float32((points[k, 1] - origin[1]) / cell)
        ix, iy = int(math.floor(fx)), int(math.floor(fy))
        first, last = max(0, iy - reach), min(shape[1], iy + reach + 1)
        for i in range(max(0, ix - reach), min(shape[0], ix + reach + 1)):
            dx = np.float32(i) + half - fx
            row = nearest[i, first:last]
            for j in range(last - first):
                dy = np.float32(first + j) + half - fy
                square = dx * dx + dy * dy
                row[j] = square if square < row[j] else row[j]
    scale = np.float32(-0.5 * (cell / sigma) ** 2)
    for i in range(shape[0]):
        row = nearest[i]
        for j in range(shape[1]):
            row[j] = math.exp(scale * row[j]) if row[j] < nothing else np.float32(0.0)
    return nearest, origin


@njit(cache=True, nogil=True)
def block_maximum(field, block):
    """out[i, j] = max field[i : i + block, j : j + block], in passes over ever larger shifts."""
    rows, columns = field.shape
    out = field.copy()
    width = 1
    while width < block:
        shift = min(width, block - width)
        for i in range(rows):
            _raise(out[i, : columns - shift], out[i, shift:])
            if i >= shift:
                _raise(out[i - shift], out[i])
        width += shift
    return out


@njit(cache=True)
def _raise(row, to):
    """row = max(row, to), in place and from left to right."""
    for j in range(len(to)):
        row[j] = to[j] if to[j] > row[j] else row[j]


@njit(cache=True, nogil=True)
def search(field, bounds, block, origin, cell, points, start, reach_xy, reach_theta, step_theta, pull):
    """Branch and bound over (x, y, θ) around `start`: the pose with the highest mean field under the points.

    `bounds` is block_maximum(field, block); translations are whole cells. `pull` is the score that a move to
    the rim of the window costs. Returns (x, y, θ) and the plain score there.
    """
    half = int(math.ceil(reach_xy / cell))
    turns = int(math.ceil(reach_theta / step_theta))
    blocks = (2 * half) // block + 1
    n = len(points)
    rows, columns = field.shape
    total = (2 * turns + 1) * blocks * blocks
    bound = np.empty(total, np.float32)
    cells = np.empty((2 * turns + 1, n, 2), np.int64)
    for r in range(2 * turns + 1):
        theta = start[2] + (r - turns) * step_theta
        c, s = math.cos(theta), math.sin(theta)
        for k in range(n):
            x = start[0] + c * points[k, 0] - s * points[k, 1]
            y = start[1] + s * points[k, 0] + c * points[k, 1]
            cells[r, k, 0] = int(math.floor((x - origin[0]) / cell))
            cells[r, k, 1] = int(math.floor((y - origin[1]) / cell))
        for bi in range(blocks):
            for bj in range(blocks):
                di, dj = -half + bi * block, -half + bj * block
                acc = np.float32(0.0)
                for k in range(n):
                    i, j = cells[r, k, 0] + di, cells[r, k, 1] + dj
                    if 0 <= i < rows and 0 <= j < columns:
                        acc += bounds[i, j]
                    elif -block < i < rows and -block < j < columns:
                        acc += bounds[max(i, 0), max(j, 0)]
                bound[(r * blocks + bi) * blocks + bj] = acc / n
    order = np.argsort(-bound)
    best, best_plain = np.float32(-1e9), np.float32(0.0)
    best_r, best_i, best_j = turns, 0, 0
    for o in order:
        if bound[o] <= best:
            break
        r = o // (blocks * blocks)
        bi = (o // blocks) % blocks
        bj = o % blocks
        turn = (r - turns) * step_theta / reach_theta
        for di in range(-half + bi * block, -half + (bi + 1) * block):
            for dj in range(-half + bj * block, -half + (bj + 1) * block):
                acc = np.float32(0.0)
                for k in range(n):
                    i, j = cells[r, k, 0] + di, cells[r, k, 1] + dj
                    if 0 <= i < rows and 0 <= j < columns:
                        acc += field[i, j]
                plain = acc / n
                away = (di * di + dj * dj) / (half * half) + turn * turn
                value = plain - np.float32(pull * away)
                if value > best:
                    best, best_plain = value, plain
                    best_r, best_i, best_j = r, di, dj
    return (
        start[0] + best_i * cell,
        start[1] + best_j * cell,
        start[2] + (best_r - turns) * step_theta,
        float(best_plain),
    )


@njit(cache=True, nogil=True)
def correlation(field, origin, cell, points, pose):
    """Mean of the field under points at a pose (x, y, θ)."""
    x, y, c, s = pose[0] - origin[0], pose[1] - origin[1], math.cos(pose[2]), math.sin(pose[2])
    rows, columns = field.shape
    total = 0.0
    for k in range(len(points)):
        i = int(math.floor((x + c * points[k, 0] - s * points[k, 1]) / cell))
        j = int(math.floor((y + s * points[k, 0] + c * points[k, 1]) / cell))
        if 0 <= i < rows and 0 <= j < columns:
            total += field[i, j]
    return total / max(len(points), 1)


@njit(cache=True, nogil=True)
def without_rivals(information, field, origin, cell, points, pose, reach):
    """The information of a match without what it says along its weakest direction, if points fit nearly as well (RIVAL
    of the correlation) somewhere else along it, from APART to `reach` (m) off.

    Along a bent wall that direction turns as it goes: it is d = (u, ω), u the principal axis of the position's
    covariance and ω the turn that goes with it. What is left is H − H d dᵀ H / (dᵀ H d).
    """
    covariance = np.linalg.inv(information + 1e-6 * np.eye(3))
    half = 0.5 * (covariance[0, 0] - covariance[1, 1])
    angle = 0.5 * math.atan2(covariance[0, 1], half)
    d = np.array([math.cos(angle), math.sin(angle), 0.0])
    along = covariance @ d
    d[2] = along[2] / (d[0] * along[0] + d[1] * along[1])
    first, last = int(math.ceil(APART / cell)), int(max(reach, APART) / cell)
    rival = 0.0
    for step in range(-last, last + 1):
        if abs(step) >= first:
            rival = max(rival, correlation(field, origin, cell, points, pose + step * cell * d))
    if rival < RIVAL * correlation(field, origin, cell, points, pose):
        return information
    told = information @ d
    return information - np.outer(told, told) / max(d @ told, 1e-9)


@njit(cache=True)
def bucket_points(points, origin, shape, cell):
    """Counting sort of points into square buckets: (start of each bucket, point indices)."""
    rows, columns = shape[0], shape[1]
    start = np.zeros(rows * columns + 1, np.int64)
    where = np.empty(len(points), np.int64)
    for k in range(len(points)):
        i = min(max(int(math.floor((points[k, 0] - origin[0]) / cell)), 0), rows - 1)
        j = min(max(int(math.floor((points[k, 1] - origin[1]) / cell)), 0), columns - 1)
        where[k] = i * columns + j
        start[where[k] + 1] += 1
    for b in range(rows * columns):
        start[b + 1] += start[b]
    order = np.empty(len(points), np.int64)
    fill = start[:-1].copy()
    for k in range(len(points)):
        order[fill[where[k]]] = k
        fill[where[k]] += 1
    return start, order


@njit(cache=True, nogil=True)
def gather(points, normals, sizes, poses, cell):
    """Points and normals of several scans, `sizes[k]` from each, put into the world and sorted by square buckets.

    Where beams meet a flat surface far apart, there are points between them too: see `between`. Returns all with the
    start of each bucket, the corner of the first one, and how many rows and columns there are.
    """
    more = between(points, normals, sizes)
    n = len(points) + more.sum()
    placed, across = np.empty((n, 2)), np.empty((n, 2))
    k = first = 0
    for one in range(len(sizes)):
        x, y = poses[one, 0], poses[one, 1]
        c, s = math.cos(poses[one, 2]), math.sin(poses[one, 2])
        for p in range(first, first + sizes[one]):
            for step in range(more[p] + 1):
                share = step / (more[p] + 1)
                q = p + 1 if step else p
                px = points[p, 0] + share * (points[q, 0] - points[p, 0])
                py = points[p, 1] + share * (points[q, 1] - points[p, 1])
                placed[k, 0] = x + c * px - s * py
                placed[k, 1] = y + s * px + c * py
                across[k, 0] = c * normals[p, 0] - s * normals[p, 1]
                across[k, 1] = s * normals[p, 0] + c * normals[p, 1]
                k += 1
        first += sizes[one]
    origin = np.array([placed[:, 0].min() - cell, placed[:, 1].min() - cell])
    shape = np.empty(2, np.int64)
    for d in range(2):
        shape[d] = int(math.ceil((placed[:, d].max() - origin[d]) / cell)) + 1
    start, order = bucket_points(placed, origin, shape, cell)
    return placed[order], across[order], start, origin, shape


@njit(cache=True)
def between(points, normals, sizes):
    """How many points FILLED apart fit between each point and the next on the same flat surface; 0 where the surface
    may end.

    It goes on where the way to the next point is at right angles to both normals and not longer than LEAP times that
    to the neighbours on both sides.
    """
    out = np.zeros(len(points), np.int64)
    first = 0
    for size in sizes:
        last = first + size - 1
        for k in range(first + 1, last - 1):
            dx, dy = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
            gap = math.sqrt(dx * dx + dy * dy)
            if gap <= FILLED:
                continue
            off = max(
                abs(normals[k, 0] * dx + normals[k, 1] * dy), abs(normals[k + 1, 0] * dx + normals[k + 1, 1] * dy)
            )
            bare = (normals[k, 0] == 0.0 and normals[k, 1] == 0.0) or (
                normals[k + 1, 0] == 0.0 and normals[k + 1, 1] == 0.0
            )
            if bare or off > FLAT * gap:
                continue
            before = math.hypot(points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1])
            after = math.hypot(points[k + 2, 0] - points[k + 1, 0], points[k + 2, 1] - points[k + 1, 1])
            if gap <= LEAP * max(before, after):
                out[k] = int(gap / FILLED)
        first += size
    return out


@njit(cache=True)
def nearest_facing(x, y, nx, ny, target, normals, start, origin, shape, cell, gate, agree, hint):
    """Nearest target point within `gate` whose normal agrees with (nx, ny) (any normal if that is zero); −1 if none.

    Points are sorted by bucket, so those of neighbouring buckets of one row follow each other. `hint` is a point that
    may be the one (−1: none is known), which spares most of the look-up.
    """
    rows, columns = shape[0], shape[1]
    best = gate * gate
    found = -1
    if hint >= 0:
        dx, dy = x - target[hint, 0], y - target[hint, 1]
        d = dx * dx + dy * dy
        if d < best and (nx * normals[hint, 0] + ny * normals[hint, 1] > agree or (nx == 0.0 and ny == 0.0)):
            best, found = d, hint
    u, v = (x - origin[0]) / cell, (y - origin[1]) / cell
    middle = int(math.floor(u))
    reach = math.sqrt(best) / cell
    away = max(middle - int(math.floor(u - reach)), int(math.floor(u + reach)) - middle)
    for o in range(2 * away + 1):
        aside = (o + 1) // 2
        i = middle + aside if o % 2 else middle - aside
        off = 0.0 if aside == 0 else (i - u if o % 2 else u - i - 1)
        if i < 0 or i >= rows or off >= reach:
            continue
        first, last = max(int(math.floor(v - reach)), 0), min(int(math.floor(v + reach)), columns - 1)
        if first > last:
            continue
        for k in range(start[i * columns + first], start[i * columns + last + 1]):
            dx, dy = x - target[k, 0], y - target[k, 1]
            d = dx * dx + dy * dy
            if d < best:
                dot = nx * normals[k, 0] + ny * normals[k, 1]
                if dot > agree or (nx == 0.0 and ny == 0.0):
                    best = d
                    found = k
        reach = math.sqrt(best) / cell
    return found


@njit(cache=True)
def _solve3(A, b):
    """Solution of a symmetric positive definite 3 × 3 system by Cramer's rule."""
    c00 = A[1, 1] * A[2, 2] - A[1, 2] * A[2, 1]
    c01 = A[0, 2] * A[2, 1] - A[0, 1] * A[2, 2]
    c02 = A[0, 1] * A[1, 2] - A[0, 2] * A[1, 1]
    c11 = A[0, 0] * A[2, 2] - A[0, 2] * A[2, 0]
    c12 = A[0, 2] * A[1, 0] - A[0, 0] * A[1, 2]
    c22 = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    det = A[0, 0] * c00 + A[0, 1] * c01 + A[0, 2] * c02
    return (
        (c00 * b[0] + c01 * b[1] + c02 * b[2]) / det,
        (c01 * b[0] + c11 * b[1] + c12 * b[2]) / det,
        (c02 * b[0] + c12 * b[1] + c22 * b[2]) / det,
    )


@njit(cache=True, nogil=True)
def _forget_open_way(H, g):
    """Take out of normal equations of (x, y, θ), in place, what the noise of normals alone says of a position.

    A long wall holds a scan along itself as firmly as its normals err, OPEN of all information, which is nothing but
    error. Each principal direction of position keeps the rest: H ← SHS and g ← Sg, S scaling by what is left.
    """
    mean, half = 0.5 * (H[0, 0] + H[1, 1]), 0.5 * (H[0, 0] - H[1, 1])
    spread = math.sqrt(half * half + H[0, 1] * H[0, 1])
    angle = 0.5 * math.atan2(H[0, 1], half)
    c, s = math.cos(angle), math.sin(angle)
    noise = 2.0 * OPEN * mean
    large = math.sqrt(max(1.0 - noise / max(mean + spread, 1e-12), 0.0))
    small = math.sqrt(max(1.0 - noise / max(mean - spread, 1e-12), 0.0))
    S = np.eye(3)
    S[0, 0] = large * c * c + small * s * s
    S[1, 1] = large * s * s + small * c * c
    S[0, 1] = S[1, 0] = (large - small) * c * s
    H[:] = S @ H @ S
    g[:] = S @ g


@njit(cache=True, nogil=True)
def refine(
    points, point_normals, target, normals, start, origin, shape, cell,
    pose, prior, prior_information, sigma, gates, inlier_gate,
):  # fmt: skip
    """Point-to-line Gauss–Newton with a Cauchy kernel (scale 2σ) and a Gaussian prior on the pose.

    One iteration per entry of `gates`, but none that would move nothing. Returns the pose, the information matrix of
    the beams alone (3, 3), the share of points within `inlier_gate` of a target line, and the RMS of those.
    """
    x, y, theta = pose[0], pose[1], pose[2]
    information = np.zeros((3, 3))
    inliers = 0
    squares = 0.0
    n = len(points)
    settled = False
    near = np.full(n, -1)
    for it in range(len(gates) + 1):
        last = settled or it == len(gates)
        gate = inlier_gate if last else gates[it]
        c, s = math.cos(theta), math.sin(theta)
        H = np.zeros((3, 3))
        g = np.zeros(3)
        inliers = 0
        squares = 0.0
        for k in range(n):
            px, py = points[k, 0], points[k, 1]
            wx, wy = x + c * px - s * py, y + s * px + c * py
            nx = c * point_normals[k, 0] - s * point_normals[k, 1]
            ny = s * point_normals[k, 0] + c * point_normals[k, 1]
            f = nearest_facing(
                wx, wy, nx, ny, target, normals, start, origin, shape, cell, max(gate, 0.1), 0.6, near[k]
            )  # fmt: skip
            near[k] = f
            if f < 0:
                continue
            tx, ty = normals[f, 0], normals[f, 1]
            if tx == 0.0 and ty == 0.0:
                continue
            r = tx * (wx - target[f, 0]) + ty * (wy - target[f, 1])
            if abs(r) > gate:
                continue
            inliers += 1
            squares += r * r
            jt = tx * (-s * px - c * py) + ty * (c * px - s * py)
            scaled = r / (2.0 * sigma)
            w = 1.0 / (1.0 + scaled * scaled) / (sigma * sigma)
            H[0, 0] += w * tx * tx
            H[0, 1] += w * tx * ty
            H[0, 2] += w * tx * jt
            H[1, 1] += w * ty * ty
            H[1, 2] += w * ty * jt
            H[2, 2] += w * jt * jt
            g[0] += w * tx * r
            g[1] += w * ty * r
            g[2] += w * jt * r
        H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]
        _forget_open_way(H, g)
        information = H
        if last:
            break
        d = np.array([x - prior[0], y - prior[1], theta - prior[2]])
        d[2] = math.atan2(math.sin(d[2]), math.cos(d[2]))
        for a in range(3):
            for b in range(3):
                g[a] += prior_information[a, b] * d[b]
        step_x, step_y, step_theta = _solve3(H + prior_information, g)
        x -= step_x
        y -= step_y
        theta -= step_theta
        moved = abs(step_x) + abs(step_y) + abs(step_theta)
        settled = gate == gates[-1] and moved < STILL
    rms = math.sqrt(squares / inliers) if inliers else 0.0
    return np.array([x, y, theta]), information, inliers / max(n, 1), rms


@njit(cache=True, nogil=True)
def find_and_refine(
    points, normals, sizes, poses, bucket, cell, field_sigma, margin, block, scan, scan_normals, thinning, guess,
    reach, turn, turn_step, pull, prior_information, sigma, gates, inlier_gate,
):  # fmt: skip
    """A scan found among others, all in one call that other threads need not wait for: `gather`, `likelihood_field`,
    `search` with thinned points, `refine`. Returns what `refine` does, and the score of the search."""
    target, across, start, origin, shape = gather(points, normals, sizes, poses, bucket)
    field, corner = likelihood_field(target, cell, field_sigma, margin)
    bounds = block_maximum(field, block)
    thinned = scan[thin(scan, thinning)]
    x, y, theta, score = search(field, bounds, block, corner, cell, thinned, guess, reach, turn, turn_step, pull)
    found = np.array([x, y, math.atan2(math.sin(theta), math.cos(theta))])
    pose, information, inliers, rms = refine(
        scan, scan_normals, target, across, start, origin, shape, bucket, found, found, prior_information, sigma,
        gates, inlier_gate,
    )  # fmt: skip
    information = without_rivals(information, field, corner, cell, thinned, pose, reach)
    return pose, information, inliers, rms, score


@njit(cache=True)
def facing_candidates(
    points, point_normals, target, normals, owner, start, order, origin, shape, cell, gate, agree, most
):
    """For each point the nearest target point of each of up to `most` different owners, nearest first; −1 beyond.

    Candidates lie within `gate` (at most one bucket) and their normals agree with the point's.
    """
    n = len(points)
    found = np.full((n, most), -1, np.int64)
    distance = np.full((n, most), np.inf)
    rows, columns = shape[0], shape[1]
    for p in range(n):
        x, y = points[p, 0], points[p, 1]
        nx, ny = point_normals[p, 0], point_normals[p, 1]
        ci = int(math.floor((x - origin[0]) / cell))
        cj = int(math.floor((y - origin[1]) / cell))
        for i in range(max(ci - 1, 0), min(ci + 2, rows)):
            for j in range(max(cj - 1, 0), min(cj + 2, columns)):
                b = i * columns + j
                for s in range(start[b], start[b + 1]):
                    k = order[s]
                    dx, dy = x - target[k, 0], y - target[k, 1]
                    d = dx * dx + dy * dy
                    if d > gate * gate or nx * normals[k, 0] + ny * normals[k, 1] < agree:
                        continue
                    place = -1
                    for m in range(most):
                        if found[p, m] >= 0 and owner[found[p, m]] == owner[k]:
                            place = m
                            break
                    if place < 0:
                        place = most - 1
                    if d >= distance[p, place]:
                        continue
                    distance[p, place] = d
                    found[p, place] = k
                    while place > 0 and distance[p, place] < distance[p, place - 1]:
                        held_d, held_k = distance[p, place - 1], found[p, place - 1]
                        distance[p, place - 1], found[p, place - 1] = distance[p, place], found[p, place]
                        distance[p, place], found[p, place] = held_d, held_k
                        place -= 1
    return found
