"""Uncertainty as 2σ ellipses (86 % of a Gaussian in the plane), and what stands for a covariance that has none."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, UInt8

from splinescope.palette import Colour, Glyph
from splinescope.scene.strokes import Strokes, glyphs, polyline

SIGMAS = 2.0
ZERO = 1e-6  # m: a standard deviation below this is none at all
FLAT = 1e-3  # ratio of the axes below which the ellipse is a line


def blocks(covariance: Float[np.ndarray, "d d"]) -> Float[np.ndarray, "n 2 2"]:
    """The 2 × 2 covariance of each control point out of that of all of them (c_1x, c_1y, c_2x, …)."""
    count = len(covariance) // 2
    return np.stack([covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] for i in range(count)])


def ellipses(
    centres: Float[np.ndarray, "n 2"],
    covariances: Float[np.ndarray, "n 2 2"],
    colours: UInt8[np.ndarray, "n 3"],
    pixel: float,
    warning: Colour,
) -> Strokes:
    """The 2σ ellipse of each centre; a small plus for no uncertainty, a line for one direction, a warning for nonsense.

    Nonsense is what no covariance can be: not finite, not symmetric, or negative in some direction.
    """
    if len(centres) == 0:
        return Strokes.none()
    values, vectors, valid = _principal(covariances)
    sigma = SIGMAS * np.sqrt(np.maximum(values, 0.0))
    point = valid & (sigma[:, 1] < ZERO)
    line = valid & ~point & (sigma[:, 0] < FLAT * sigma[:, 1])
    oval = valid & ~point & ~line
    invalid = ~valid
    return Strokes.joined(
        [
            _ovals(centres[oval], sigma[oval], vectors[oval], colours[oval], pixel),
            _lines(centres[line], sigma[line], vectors[line], colours[line]),
            glyphs(Glyph.PLUS, centres[point], colours[point], 3.0 * pixel),
            glyphs(Glyph.WARNING, centres[invalid], np.tile(warning, (int(invalid.sum()), 1)), 8.0 * pixel),
        ]
    )


def _principal(
    covariances: Float[np.ndarray, "n 2 2"],
) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n 2 2"], Bool[np.ndarray, "n"]]:
    """Variances (small, large), their directions as columns, and whether it is a covariance at all."""
    finite = np.all(np.isfinite(covariances), axis=(1, 2))
    safe = np.where(finite[:, None, None], covariances, np.eye(2))
    size = np.abs(safe).max(axis=(1, 2))
    symmetric = np.abs(safe[:, 0, 1] - safe[:, 1, 0]) <= 1e-6 * size + 1e-15
    values, vectors = np.linalg.eigh(0.5 * (safe + safe.transpose(0, 2, 1)))
    positive = values[:, 0] >= -1e-6 * size - 1e-15
    return values, vectors, np.logical_and.reduce([finite, symmetric, positive])


def _ovals(centres: np.ndarray, sigma: np.ndarray, vectors: np.ndarray, colours: np.ndarray, pixel: float) -> Strokes:
    if len(centres) == 0:
        return Strokes.none()
    count = int(np.clip(sigma.max() / pixel, 10, 28))
    angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rim = centres[:, None] + np.einsum("nij,nj,mj->nmi", vectors, sigma, unit)
    segments = np.stack([rim[:, :-1], rim[:, 1:]], axis=2).reshape(-1, 2, 2)
    return Strokes(segments, np.repeat(colours, count, axis=0))


def _lines(centres: np.ndarray, sigma: np.ndarray, vectors: np.ndarray, colours: np.ndarray) -> Strokes:
    reach = vectors[:, :, 1] * sigma[:, 1:]
    segments = [polyline(np.stack([c - r, c + r])) for c, r in zip(centres, reach, strict=True)]
    return Strokes(np.concatenate([np.zeros((0, 2, 2)), *segments]), colours)
