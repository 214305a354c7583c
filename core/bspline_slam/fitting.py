"""Curves from points: chord-length parameters (the paper), foot points (what minimises distance), and their
covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline, clamped_knots
from bspline_slam.errors import GeometryError
from bspline_slam.kernels import fitting as kernels
from bspline_slam.kernels.basis import basis_rows


@dataclass(frozen=True, slots=True)
class FittingConfig:
    """Degree of the curves (adjustment leaves plain ones a lower one), knot spacing on the map (m), noise of the laser
    (m, rad), and the stiffness that decides what data leave open: standard deviation of second differences of control
    points (m)."""

    degree: int = 3
    spacing: float = 0.4
    range_noise: float = 0.012
    bearing_noise: float = 0.003
    stiffness: float = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """A curve fitted to points: its parameters, RMS distance (m) and covariance of (c_1x, c_1y, c_2x, …)."""

    curve: BSpline
    parameters: Float[np.ndarray, "m"]
    rms: float
    covariance: Float[np.ndarray, "d d"]


def chord_length_parameters(points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
    """Cumulated chord length as a share of the whole, in [0, 1] (paper, eqs 8–10)."""
    length = cumulated_chords(points)
    return length / max(length[-1], 1e-12)


def cumulated_chords(points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
    """Length of the polygon from the first point to each point (m)."""
    return kernels.cumulated_chords(points)


def beam_covariances(
    points: Float[np.ndarray, "m 2"], range_noise: float, bearing_noise: float
) -> Float[np.ndarray, "m 2 2"]:
    """Polar noise of beam ends turned into x, y; points in the frame of the sensor (paper, eq. 11)."""
    reach = np.maximum(np.linalg.norm(points, axis=1), 1e-9)
    u = points / reach[:, None]
    v = np.stack([-u[:, 1], u[:, 0]], -1)
    along = range_noise**2 * np.einsum("mi,mj->mij", u, u)
    return along + np.einsum("m,mi,mj->mij", (bearing_noise * reach) ** 2, v, v)


def second_differences(count: int) -> Float[np.ndarray, "rows n"]:
    """Matrix of c_{i−1} − 2 c_i + c_{i+1}."""
    return np.diff(np.eye(count), n=2, axis=0)


def fit(points: Float[np.ndarray, "m 2"], config: FittingConfig = FittingConfig()) -> Fit:
    """The curve of one segment (points in the sensor's frame, in order): chord-length start, then foot points.

    Raises GeometryError with fewer than two distinct points.
    """
    return fit_foot_points(points, fit_chord_length(points, config), config)


def fit_chord_length(points: Float[np.ndarray, "m 2"], config: FittingConfig = FittingConfig()) -> Fit:
    """The curve of one segment by chord-length parameters alone: many times faster, and hardly another curve.

    Clamped, with as many control points as its length asks for at the configured spacing and its points allow.
    Raises GeometryError with fewer than two distinct points.
    """
    length = cumulated_chords(points)[-1]
    if len(points) < 2 or length < 1e-9:
        raise GeometryError(f"a curve needs at least two distinct points, got {len(points)}")
    wanted = int(np.ceil(length / config.spacing)) + config.degree
    count = max(min(wanted, max(len(points) // 2, 2)), config.degree + 1)
    return fit_parameters(points, chord_length_parameters(points), clamped_knots(count, config.degree), config)


def fit_parameters(
    points: Float[np.ndarray, "m 2"], t: Float[np.ndarray, "m"], knots: Float[np.ndarray, "k"], config: FittingConfig
) -> Fit:
    """Least squares with fixed parameters (paper, eqs 4–7, 12), the second differences held weakly."""
    count = len(knots) - config.degree - 1
    frame = BSpline(config.degree, knots, np.zeros((count, 2)))
    B = frame.basis(t)
    D = second_differences(count) * (config.range_noise / config.stiffness)
    inverse = np.linalg.inv(B.T @ B + D.T @ D + 1e-12 * np.eye(count))
    gain = inverse @ B.T
    noise = beam_covariances(points, config.range_noise, config.bearing_noise)
    covariance = np.einsum("im,mab,jm->iajb", gain, noise, gain).reshape(2 * count, 2 * count)
    shape = np.linalg.multi_dot([inverse, D.T, D, inverse]) * config.range_noise**2
    curve = frame.with_control_points(gain @ points)
    return Fit(curve, t, _rms(curve, t, points), covariance + np.kron(shape, np.eye(2)))


def fit_foot_points(points: Float[np.ndarray, "m 2"], start: Fit, config: FittingConfig, iterations: int = 3) -> Fit:
    """Foot points found again and refitted (Hoschek's intrinsic parametrisation), ends kept at the ends of the
    domain."""
    found = start
    for _ in range(iterations):
        t = found.curve.foot_points(points)
        low, high = found.curve.domain
        t[0], t[-1] = low, high
        found = fit_parameters(points, np.maximum.accumulate(t), found.curve.knots, config)
    return found


def uniform_through(points: Float[np.ndarray, "m 2"], config: FittingConfig) -> BSpline:
    """A map curve through ordered points: uniform knots of the configured spacing, parameter = arc length from 0."""
    stiffness = config.range_noise / config.stiffness
    return BSpline(config.degree, *kernels.uniform_curve(points, config.spacing, config.degree, stiffness))


def curve_through(
    points: Float[np.ndarray, "m 2"], t: Float[np.ndarray, "m"], knots: Float[np.ndarray, "k"], config: FittingConfig
) -> BSpline:
    """The curve of `fit_parameters`, many times faster without its covariance."""
    count = len(knots) - config.degree - 1
    first, basis = basis_rows(knots, config.degree, t, 0)
    stiffness = config.range_noise / config.stiffness
    found = kernels.control_points(first, basis, points, np.zeros((count, 2)), 0, stiffness)
    return BSpline(config.degree, knots, found)


def _rms(curve: BSpline, t: Float[np.ndarray, "m"], points: Float[np.ndarray, "m 2"]) -> float:
    off = ((curve(t) - points) * curve.normals(t)).sum(1)
    return float(np.sqrt(np.mean(off**2)))
