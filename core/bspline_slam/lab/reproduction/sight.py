"""One curve in front of one laser: the paper's simulator, its observation and the covariance it claims."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.fitting import FittingConfig
from bspline_slam.models import ChordLengthConfig
from bspline_slam.observation import ChordLengthNoise
from bspline_slam.observation_steps import ObservedSpline, observe_spline

CONTROL_POINTS = ChordLengthConfig().control_points
"""Of every fitted spline, as on the paper's map of the Intel Lab."""
RANGE_NOISE = 0.012
"""Standard deviation of ranges (m; paper, section 3.3.2)."""
FINE, COARSE = float(np.radians(0.1)), float(np.radians(0.5))
"""Angles between beams (rad; paper, sections 3.3.1 and 3.3.2)."""
FITTING = FittingConfig(range_noise=RANGE_NOISE, bearing_noise=0.0)
"""The simulated beams err in range alone."""
TERMS = ChordLengthNoise()
"""P_t1 and P_t2 as the product has them; `cons` is free in the paper."""

REFERENCE = BSpline(
    3,
    clamped_knots(9),
    np.array([
        [-3.2, 1.6], [-2.8, 3.0], [-1.7, 4.3], [-0.6, 3.2], [0.4, 3.1], [1.3, 4.6], [2.4, 4.1], [2.9, 2.9], [3.4, 1.5],
    ]),
)  # fmt: skip
"""The reference spline of Figs 2 to 7 (world frame, m); its parameter is not proportional to length."""
FIRST_POSE = np.array([0.0, 0.0, np.pi / 2])
SECOND_POSE = np.array([0.5, 0.6, np.pi / 2 - 0.25])
"""Two places from which the whole of it is in sight."""


def scan_curve(
    curve: BSpline,
    pose: Float[np.ndarray, "3"],
    resolution: float,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> Float[np.ndarray, "m 2"]:
    """Where the beams of a half circle ahead meet the curve (robot frame, in the order of the beams)."""
    bearings = np.arange(-np.pi / 2, np.pi / 2 + 1e-9, resolution)
    directions = np.stack([np.cos(bearings), np.sin(bearings)], -1)
    ranges, _ = curve.ray_hits(pose[:2], se2.rotate(pose, directions))
    hit = np.isfinite(ranges)
    ranges = ranges[hit]
    if rng is not None:
        ranges = ranges + noise * rng.standard_normal(len(ranges))
    return ranges[:, None] * directions[hit]


def observe(points: Float[np.ndarray, "m 2"], terms: ChordLengthNoise = TERMS) -> ObservedSpline:
    """The whole of a spline observed: chord-length parameters, least squares, covariance (paper, eqs 4–15)."""
    frame = BSpline(3, clamped_knots(CONTROL_POINTS), np.zeros((CONTROL_POINTS, 2)))
    return observe_spline(points, frame, FITTING, terms)
