"""A scan put on the finished map, in one compiled call that other threads need not wait for."""

from numba import njit

from bspline_slam.kernels.matching import refine
from bspline_slam.kernels.surfaces import points_with_normals


@njit(cache=True, nogil=True)
def place(beams, limits, target, guess, prior_information, sigma, gates, inlier_gate):
    """`refine` of the `points_with_normals` of a scan: `beams` and `limits` are what these ask for, `target` what
    `refine` does. Returns the pose and the share of inliers; none of these where the scan shows nothing."""
    points, normals = points_with_normals(*beams, *limits)
    if len(points) == 0:
        return guess, 0.0
    surface, across, start, origin, shape, bucket = target
    pose, _, inliers, _ = refine(
        points, normals, surface, across, start, origin, shape, bucket, guess, guess, prior_information, sigma, gates,
        inlier_gate,
    )  # fmt: skip
    return pose, inliers
