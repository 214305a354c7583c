"""Cost, gradient and Gauss-Newton matrix of the whole problem, in blocks.

The blocks of the matrix: `H_pose` (n, 3, 3) on the diagonal of the poses, `H_edge` (P, 3, 3) with the rows of the
earlier pose, `H_sight` (Q, 2, 3) with the rows of a control point and the columns of a pose that sees it, and
`H_curve` (N, w, 2, 2), where [k, d] has the rows of control point k and the columns of control point k + d.

Curve terms are e = A·vec(Rᵀ(c − x)) − b, flat one after another: `size` (F, 2) holds the rows r and the number of
control points m, `start` (F, 3) where A, b and AᵀA begin. A term of pose −1 is seen from the world frame itself.
Edge terms are relative poses; a tail of −1 is the world frame; `kernel` is the Cauchy width, inf for none.
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def square_terms(size, start, A, gram):
    """Fill `gram` with AᵀA of each curve term."""
    for f in range(len(size)):
        r, w = size[f, 0], 2 * size[f, 1]
        a = A[start[f, 0] : start[f, 0] + r * w].reshape(r, w)
        square = gram[start[f, 2] : start[f, 2] + w * w].reshape(w, w)
        for i in range(w):
            for j in range(i, w):
                square[i, j] = 0.0
            for row in range(r):
                factor = a[row, i]
                for j in range(i, w):
                    square[i, j] += factor * a[row, j]
            for j in range(i + 1, w):
                square[j, i] = square[i, j]


@njit(cache=True, nogil=True)
def _largest(size):
    """Most rows and most control points of any term."""
    rows, points = 0, 0
    for f in range(len(size)):
        rows, points = max(rows, size[f, 0]), max(points, size[f, 1])
    return rows, points


@njit(cache=True, nogil=True)
def _curve_residual(f, pose, control_points, first, size, start, A, b, q, e):
    """Points in the observing frame into q (2m) and the residual into e (r); returns cos θ and sin θ."""
    r, m = size[f, 0], size[f, 1]
    c, s, x, y = 1.0, 0.0, 0.0, 0.0
    if len(pose) > 0:
        c, s, x, y = np.cos(pose[2]), np.sin(pose[2]), pose[0], pose[1]
    for k in range(m):
        dx, dy = control_points[first[f] + k, 0] - x, control_points[first[f] + k, 1] - y
        q[2 * k], q[2 * k + 1] = c * dx + s * dy, c * dy - s * dx
    a = start[f, 0]
    for i in range(r):
        total = -b[start[f, 1] + i]
        for k in range(2 * m):
            total += A[a + k] * q[k]
        e[i] = total
        a += 2 * m
    return c, s


@njit(cache=True, nogil=True)
def curve_cost(poses, control_points, observer, first, size, start, A, b):
    """Σ ‖e‖² of all curve terms."""
    rows, points = _largest(size)
    q, e, total = np.empty(2 * points), np.empty(rows), 0.0
    for f in range(len(first)):
        pose = poses[observer[f]] if observer[f] >= 0 else poses[0, :0]
        _curve_residual(f, pose, control_points, first, size, start, A, b, q, e)
        for i in range(size[f, 0]):
            total += e[i] * e[i]
    return total


@njit(cache=True, nogil=True)
def linearise_curves(
    poses, control_points, observer, first, size, start, A, b, gram, sight, H_pose, H_sight, H_curve, g_pose, g_curve,
    S_pose, S_sight,
):  # fmt: skip
    """Add the curve terms to the blocks of the Gauss-Newton matrix and to the gradient, and to `S_pose` and `S_sight`
    what Newton's matrix has beyond it: with g = Aᵀe, the sum of g·∂²q over the points."""
    rows, points = _largest(size)
    q, e, u = np.empty(2 * points), np.empty(rows), np.empty((2 * points, 3))
    for f in range(len(first)):
        i, k0, r, w = observer[f], first[f], size[f, 0], 2 * size[f, 1]
        pose = poses[i] if i >= 0 else poses[0, :0]
        c, s = _curve_residual(f, pose, control_points, first, size, start, A, b, q, e)
        a, G = start[f, 0], gram[start[f, 2] : start[f, 2] + w * w].reshape(w, w)
        for k in range(w // 2):
            g_x, g_y = 0.0, 0.0
            for j in range(r):
                g_x += A[a + j * w + 2 * k] * e[j]
                g_y += A[a + j * w + 2 * k + 1] * e[j]
            g_curve[k0 + k, 0] += c * g_x - s * g_y
            g_curve[k0 + k, 1] += s * g_x + c * g_y
            if i >= 0:
                g_pose[i, 0] -= c * g_x - s * g_y
                g_pose[i, 1] -= s * g_x + c * g_y
                g_pose[i, 2] += g_x * q[2 * k + 1] - g_y * q[2 * k]
                u_x, u_y = -s * g_x - c * g_y, c * g_x - s * g_y
                S_sight[sight[f] + k, 0, 2] += u_x
                S_sight[sight[f] + k, 1, 2] += u_y
                S_pose[i, 0, 2] -= u_x
                S_pose[i, 1, 2] -= u_y
                S_pose[i, 2, 0] -= u_x
                S_pose[i, 2, 1] -= u_y
                S_pose[i, 2, 2] -= g_x * q[2 * k] + g_y * q[2 * k + 1]
        _linearise_points(G, c, s, H_curve[k0 : k0 + w // 2])
        if i >= 0:
            _linearise_observer(G, q, c, s, u, H_pose[i], H_sight[sight[f] : sight[f] + w // 2])


@njit(cache=True, nogil=True)
def curve_information(poses, observer, first, size, start, gram, H_curve):
    """Add the curve terms to the blocks of the control points alone."""
    for f in range(len(first)):
        i, k0, w = observer[f], first[f], 2 * size[f, 1]
        c, s = (np.cos(poses[i, 2]), np.sin(poses[i, 2])) if i >= 0 else (1.0, 0.0)
        _linearise_points(gram[start[f, 2] : start[f, 2] + w * w].reshape(w, w), c, s, H_curve[k0 : k0 + w // 2])


@njit(cache=True, nogil=True)
def _linearise_points(G, c, s, H_curve):
    """The blocks R G_kl Rᵀ of the observed control points."""
    for k in range(len(G) // 2):
        for d in range(len(G) // 2 - k):
            far, block = k + d, H_curve[k, d]
            xx, xy = G[2 * k, 2 * far], G[2 * k, 2 * far + 1]
            yx, yy = G[2 * k + 1, 2 * far], G[2 * k + 1, 2 * far + 1]
            tx, ty = c * xx - s * yx, c * xy - s * yy
            vx, vy = s * xx + c * yx, s * xy + c * yy
            block[0, 0] += tx * c - ty * s
            block[0, 1] += tx * s + ty * c
            block[1, 0] += vx * c - vy * s
            block[1, 1] += vx * s + vy * c


@njit(cache=True, nogil=True)
def _linearise_observer(G, q, c, s, u, H_pose, H_sight):
    """The blocks of the observing pose: ∂q/∂(x, y, θ) = (−Rᵀ, (q_y, −q_x)) =: D, u = G D."""
    w = len(G)
    for a in range(w):
        s_x, s_y, s_t = 0.0, 0.0, 0.0
        for k in range(w // 2):
            s_x += G[a, 2 * k]
            s_y += G[a, 2 * k + 1]
            s_t += G[a, 2 * k] * q[2 * k + 1] - G[a, 2 * k + 1] * q[2 * k]
        u[a, 0], u[a, 1], u[a, 2] = s * s_y - c * s_x, -s * s_x - c * s_y, s_t
    for k in range(w // 2):
        for col in range(3):
            u_x, u_y = u[2 * k, col], u[2 * k + 1, col]
            h_x, h_y = c * u_x - s * u_y, s * u_x + c * u_y
            H_sight[k, 0, col] += h_x
            H_sight[k, 1, col] += h_y
            H_pose[0, col] -= h_x
            H_pose[1, col] -= h_y
            H_pose[2, col] += q[2 * k + 1] * u_x - q[2 * k] * u_y


@njit(cache=True, nogil=True)
def _edge_residual(f, poses, tail, head, measured, sqrt_information, e):
    """Residual into e (3); returns the turned baseline and cos, sin of the turn, for the Jacobian."""
    x, y, angle = poses[head[f], 0], poses[head[f], 1], poses[head[f], 2] - measured[f, 2]
    turn = measured[f, 2]
    if tail[f] >= 0:
        x, y, angle = x - poses[tail[f], 0], y - poses[tail[f], 1], angle - poses[tail[f], 2]
        turn += poses[tail[f], 2]
    c, s = np.cos(turn), np.sin(turn)
    c_z, s_z = np.cos(measured[f, 2]), np.sin(measured[f, 2])
    base_x, base_y = c * x + s * y, c * y - s * x
    d_x = base_x - c_z * measured[f, 0] - s_z * measured[f, 1]
    d_y = base_y - c_z * measured[f, 1] + s_z * measured[f, 0]
    angle -= 2.0 * np.pi * np.floor(angle / (2.0 * np.pi) + 0.5)
    S = sqrt_information[f]
    for i in range(3):
        e[i] = S[i, 0] * d_x + S[i, 1] * d_y + S[i, 2] * angle
    return base_x, base_y, c, s


@njit(cache=True, nogil=True)
def edge_cost(poses, tail, head, measured, sqrt_information, kernel):
    """Σ ρ(‖e‖²) and Σ w ‖e‖², where w = ρ′ is the weight of the robust kernel, of all edge terms."""
    e, cost, chi2 = np.empty(3), 0.0, 0.0
    for f in range(len(head)):
        _edge_residual(f, poses, tail, head, measured, sqrt_information, e)
        square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
        if np.isinf(kernel[f]):
            cost += square
            chi2 += square
        else:
            width = kernel[f] * kernel[f]
            cost += width * np.log1p(square / width)
            chi2 += square / (1.0 + square / width)
    return cost, chi2


@njit(cache=True, nogil=True)
def linearise_edges(
    poses, tail, head, measured, sqrt_information, kernel, slot, H_pose, H_edge, g_pose, S_pose, S_edge
):  # fmt: skip
    """Add the edge terms to the blocks of the Gauss-Newton matrix and to the gradient, and to `S_pose` and `S_edge`
    what Newton's matrix has beyond it."""
    e, J_i, J_j, v_i, v_j = np.empty(3), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    for f in range(len(head)):
        base_x, base_y, c, s = _edge_residual(f, poses, tail, head, measured, sqrt_information, e)
        square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
        weight = 1.0 / (1.0 + square / (kernel[f] * kernel[f]))
        flatter = -2.0 * weight * weight / (kernel[f] * kernel[f])
        S = sqrt_information[f]
        for row in range(3):
            J_j[row, 0] = c * S[row, 0] - s * S[row, 1]
            J_j[row, 1] = s * S[row, 0] + c * S[row, 1]
            J_j[row, 2] = S[row, 2]
            J_i[row, 0], J_i[row, 1] = -J_j[row, 0], -J_j[row, 1]
            J_i[row, 2] = base_y * S[row, 0] - base_x * S[row, 1] - S[row, 2]
        i, j = tail[f], head[f]
        for a in range(3):
            v_i[a] = J_i[0, a] * e[0] + J_i[1, a] * e[1] + J_i[2, a] * e[2]
            v_j[a] = J_j[0, a] * e[0] + J_j[1, a] * e[1] + J_j[2, a] * e[2]
        for a in range(3):
            g_pose[j, a] += weight * v_j[a]
            for d in range(3):
                H_pose[j, a, d] += weight * (J_j[0, a] * J_j[0, d] + J_j[1, a] * J_j[1, d] + J_j[2, a] * J_j[2, d])
                S_pose[j, a, d] += flatter * v_j[a] * v_j[d]
                if i < 0:
                    continue
                H_pose[i, a, d] += weight * (J_i[0, a] * J_i[0, d] + J_i[1, a] * J_i[1, d] + J_i[2, a] * J_i[2, d])
                S_pose[i, a, d] += flatter * v_i[a] * v_i[d]
                cross = weight * (J_i[0, a] * J_j[0, d] + J_i[1, a] * J_j[1, d] + J_i[2, a] * J_j[2, d])
                if i < j:
                    H_edge[slot[f], a, d] += cross
                    S_edge[slot[f], a, d] += flatter * v_i[a] * v_j[d]
                else:
                    H_edge[slot[f], d, a] += cross
                    S_edge[slot[f], d, a] += flatter * v_i[a] * v_j[d]
            if i >= 0:
                g_pose[i, a] += weight * v_i[a]
        if i >= 0:
            _bend_edge(i, i < j, slot[f], weight, S, e, base_x, base_y, c, s, S_pose, S_edge)


@njit(cache=True, nogil=True)
def _bend_edge(i, forward, slot, weight, S, e, base_x, base_y, c, s, S_pose, S_edge):
    """Residual times second derivative of one relative pose: as of a single point seen from its tail."""
    h_x = weight * (S[0, 0] * e[0] + S[1, 0] * e[1] + S[2, 0] * e[2])
    h_y = weight * (S[0, 1] * e[0] + S[1, 1] * e[1] + S[2, 1] * e[2])
    u_x, u_y = -s * h_x - c * h_y, c * h_x - s * h_y
    S_pose[i, 2, 2] -= h_x * base_x + h_y * base_y
    S_pose[i, 0, 2] -= u_x
    S_pose[i, 1, 2] -= u_y
    S_pose[i, 2, 0] -= u_x
    S_pose[i, 2, 1] -= u_y
    if forward:
        S_edge[slot, 2, 0] += u_x
        S_edge[slot, 2, 1] += u_y
    else:
        S_edge[slot, 0, 2] += u_x
        S_edge[slot, 1, 2] += u_y
