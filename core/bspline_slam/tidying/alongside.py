"""Curves that run beside each other: which places of one lie along another that faces the same way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.kernels import matching as kernels
from bspline_slam.spline_map import MapSpline

AGREEMENT = 0.9
"""Least cosine between the normals of curves that run alike: the two faces of a thin wall do not."""
NEIGHBOURS = 4
"""Of so many curves near a place, the nearest, each is looked at."""


@dataclass(frozen=True, eq=False, slots=True)
class CurveSamples:
    """Samples of curves, curve by curve: the place of the curve among them, parameter, world point, unit normal.

    They are about `spacing` (m) apart, and curve k has the samples `first[k]` … `first[k + 1]` − 1.
    """

    spacing: float
    first: Int[np.ndarray, "k1"]
    owner: Int[np.ndarray, "s"]
    t: Float[np.ndarray, "s"]
    points: Float[np.ndarray, "s 2"]
    normals: Float[np.ndarray, "s 2"]

    @classmethod
    def of(cls, splines: Sequence[MapSpline], spacing: float) -> CurveSamples:
        """Of the supported stretches of one spline or more."""
        sampled = [one.curve.sample_with_normals(spacing, one.span) for one in splines]
        t, points, normals = (np.concatenate(column) for column in zip(*sampled, strict=True))
        counts = [len(each) for each, *_ in sampled]
        first = np.concatenate([[0], np.cumsum(counts)])
        return cls(spacing, first, np.repeat(np.arange(len(counts)), counts), t, points, normals)

    def near(self, owner: Int[np.ndarray, "m"], t: Float[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
        """Of places on these curves, by parameter, the samples near them; parameters are about metres along curves."""
        first, last = self.first[:-1], self.first[1:] - 1
        step = (self.t[last] - self.t[first]) / np.maximum(last - first, 1)
        number = np.rint((t - self.t[first][owner]) / np.maximum(step, 1e-9)[owner]).astype(np.int64)
        return np.clip(first[owner] + number, first[owner], last[owner])


@dataclass(frozen=True, eq=False, slots=True)
class Alongside:
    """Pairs of samples of different curves, side by side: `sample`, the nearest on the other curve, and how far in
    front of that curve the first lies (m; negative: behind it)."""

    sample: Int[np.ndarray, "p"]
    beside: Int[np.ndarray, "p"]
    across: Float[np.ndarray, "p"]

    def part(self, chosen: Bool[np.ndarray, "p"]) -> Alongside:
        """The chosen pairs."""
        return Alongside(self.sample[chosen], self.beside[chosen], self.across[chosen])


def alongside(samples: CurveSamples, within: float) -> Alongside:
    """Samples no farther than `within` (m) from another curve, not beyond its ends, that faces the same way."""
    points, normals, owner = samples.points, samples.normals, samples.owner
    gate = float(np.hypot(within, samples.spacing))
    origin = points.min(0) - gate
    grid = np.ceil((points.max(0) - origin) / gate).astype(np.int64) + 1
    start, order = kernels.bucket_points(points, origin, grid, gate)
    near = kernels.facing_candidates(
        points, normals, points, normals, owner, start, order, origin, grid, gate, gate, AGREEMENT, NEIGHBOURS
    )
    first, column = np.nonzero((near >= 0) & (owner[near] != owner[:, None]))
    second = near[first, column]
    off, normal = points[first] - points[second], normals[second]
    across = (off * normal).sum(1)
    along = off[:, 0] * normal[:, 1] - off[:, 1] * normal[:, 0]
    kept = (np.abs(across) < within) & (np.abs(along) < samples.spacing)
    return Alongside(first[kept], second[kept], across[kept])
