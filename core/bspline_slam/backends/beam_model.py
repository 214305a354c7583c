"""Where a beam meets a curve: the predicted range and its derivatives (BS-SLAM, Pedraza et al. 2007).

A beam starts at o in the world and points along u; v is u turned left. It meets the curve s where v·(s(t) − o) = 0,
and its range is z = u·(s(t) − o). With g = (u·s′)/(v·s′) and w = u − g v, what moves the curve point by ds or the
origin by do changes the range by w·(ds − do), and turning the beam by dθ by z g dθ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.bspline import BSpline, basis_rows

GRAZING = 0.15
"""Least |cosine| between beam and curve normal: below it the range says hardly anything, and nothing linearly."""
NEWTON_STEPS = 10


@dataclass(frozen=True, eq=False, slots=True)
class BeamPrediction:
    """Ranges (m) and their derivatives by (x, y, θ) of the robot and by the k control points from `first` on.

    `incidence` is |cosine| between beam and curve normal. `meets` is false for beams that miss the curve, start
    behind it, or graze it: their values mean nothing.
    """

    ranges: Float[np.ndarray, "m"]
    incidence: Float[np.ndarray, "m"]
    by_pose: Float[np.ndarray, "m 3"]
    first: Int[np.ndarray, "m"]
    by_points: Float[np.ndarray, "m k 2"]
    meets: Bool[np.ndarray, "m"]


def predict_ranges(
    curve: BSpline,
    pose: Float[np.ndarray, "3"],
    origins: Float[np.ndarray, "m 2"],
    directions: Float[np.ndarray, "m 2"],
    parameters: Float[np.ndarray, "m"],
) -> BeamPrediction:
    """Ranges of beams (robot frame) to a curve (world frame); `parameters` are where on it the search begins."""
    arms, along = se2.rotate(pose, origins), se2.rotate(pose, directions)
    beside = np.stack([-along[:, 1], along[:, 0]], -1)
    starts = pose[:2] + arms
    t = _crossings(curve, starts, beside, parameters)
    first, basis = basis_rows(curve.knots, curve.degree, t)
    reach, slope = curve(t) - starts, curve(t, 1)
    ranges, across = (along * reach).sum(1), (beside * slope).sum(1)
    incidence = np.abs(across) / np.maximum(np.linalg.norm(slope, axis=1), 1e-12)
    meets = (np.abs((beside * reach).sum(1)) < 1e-7) & (ranges > 0.0) & (incidence >= GRAZING)
    g = (along * slope).sum(1) / np.where(meets, across, 1.0)
    w = along - g[:, None] * beside
    by_turn = ranges * g - w[:, 1] * arms[:, 0] + w[:, 0] * arms[:, 1]
    by_pose, by_points = np.column_stack([-w, by_turn]), basis[:, :, None] * w[:, None, :]
    return BeamPrediction(ranges, incidence, by_pose, first, by_points, meets)


def _crossings(
    curve: BSpline,
    starts: Float[np.ndarray, "m 2"],
    beside: Float[np.ndarray, "m 2"],
    t: Float[np.ndarray, "m"],
) -> Float[np.ndarray, "m"]:
    """Newton's method on v·(s(t) − o) = 0 inside the domain; steps are held to one control point's reach."""
    low, high = curve.domain
    longest = (high - low) / (len(curve.control_points) - curve.degree)
    for _ in range(NEWTON_STEPS):
        value, slope = (beside * (curve(t) - starts)).sum(1), (beside * curve(t, 1)).sum(1)
        step = value / np.where(np.abs(slope) > 1e-12, slope, np.inf)
        t = np.clip(t - np.clip(step, -longest, longest), low, high)
        if np.abs(step).max(initial=0.0) < 1e-12:
            break
    return t
