"""How much each curve term has of the cost."""

import numpy as np
from numba import njit

from bspline_slam.kernels.linearise import _curve_residual, _largest


@njit(cache=True, nogil=True)
def curve_squares(poses, control_points, observer, first, size, start, A, b, squares):
    """Fill `squares` with ‖e‖² of each curve term (as in `kernels.linearise`)."""
    rows, points = _largest(size)
    q, e = np.empty(2 * points), np.empty(rows)
    for f in range(len(first)):
        pose = poses[observer[f]] if observer[f] >= 0 else poses[0, :0]
        _curve_residual(f, pose, control_points, first, size, start, A, b, q, e)
        squares[f] = 0.0
        for i in range(size[f, 0]):
            squares[f] += e[i] * e[i]
