"""The gradient of curve terms alone, where their matrix is known well enough already."""

import numpy as np
from numba import njit

from bspline_slam.kernels.linearise import _curve_residual, _largest


@njit(cache=True, nogil=True)
def curve_gradient(poses, control_points, observer, first, size, start, A, b, g_pose, g_curve):
    """Add the curve terms (as in `kernels.linearise`) to the gradient of ½ Σ ‖e‖² by poses and by control points."""
    rows, points = _largest(size)
    q, e = np.empty(2 * points), np.empty(rows)
    for f in range(len(first)):
        i, k0, r, w = observer[f], first[f], size[f, 0], 2 * size[f, 1]
        pose = poses[i] if i >= 0 else poses[0, :0]
        c, s = _curve_residual(f, pose, control_points, first, size, start, A, b, q, e)
        a = start[f, 0]
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
