"""Curves as rows of samples: which of them lie near a place and face the same way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.kernels import matching as kernels
from bspline_slam.spline_map import MapSpline


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

    def facing(
        self,
        points: Float[np.ndarray, "p 2"],
        normals: Float[np.ndarray, "p 2"],
        within: float,
        agree: float,
        most: int,
    ) -> Int[np.ndarray, "p most"]:
        """Of points, each with a unit normal, the nearest sample of each of up to `most` curves, nearest first; −1
        where there are no more. None is farther than `within` (m), nor the cosine between the normals below `agree`."""
        origin = self.points.min(0) - within
        grid = np.ceil((self.points.max(0) - origin) / within).astype(np.int64) + 1
        start, order = kernels.bucket_points(self.points, origin, grid, within)
        return kernels.facing_candidates(
            points,
            normals,
            self.points,
            self.normals,
            self.owner,
            start,
            order,
            origin,
            grid,
            within,
            within,
            agree,
            most,
        )

    def apart(
        self, points: Float[np.ndarray, "p 2"], sample: Int[np.ndarray, "p"]
    ) -> tuple[Float[np.ndarray, "p"], Float[np.ndarray, "p"]]:
        """How far (m) each point lies in front of its sample (negative: behind it), and how far on along the curve."""
        off, normal = points - self.points[sample], self.normals[sample]
        return (off * normal).sum(1), off[:, 0] * normal[:, 1] - off[:, 1] * normal[:, 0]
