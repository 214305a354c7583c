"""An estimate and its covariances as seen from the frame that fits all key positions best, not from the first key pose.

One pose is a poor place to look from: its own error moves and turns everything else, all of one trial alike. A change
of the frame (S-transformation, Baarda 1973) is a rigid motion δ = (x, y, θ) about the middle of the key positions,
linear in their errors. It takes an error e to e − G δ, and so its covariance C to C − c Gᵀ − G cᵀ + G D Gᵀ, with c the
covariance of e and δ, and D that of δ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.protocol import Estimate
from bspline_slam.measuring import factorised


@dataclass(frozen=True, eq=False, slots=True)
class BestFrame:
    """`middle` of the key positions (m), the covariance of all unknowns with δ, and that of δ itself."""

    middle: Float[np.ndarray, "2"]
    with_all: Float[np.ndarray, "u 3"]
    own: Float[np.ndarray, "3 3"]

    @classmethod
    def of(cls, estimate: Estimate) -> BestFrame:
        """That of an estimate, with at least two key poses apart from each other."""
        places = estimate.poses[:, :2]
        arms = places - places.mean(0)
        by = np.zeros((estimate.graph.unknowns, 3))
        poses = by[: 3 * len(places)].reshape(-1, 3, 3)
        poses[:, 0, 0] = poses[:, 1, 1] = 1.0 / len(places)
        poses[:, :2, 2] = np.column_stack([-arms[:, 1], arms[:, 0]]) / np.square(arms).sum()
        with_all = factorised(estimate).solve(by)
        return cls(places.mean(0), with_all, by.T @ with_all)

    def pose(self, estimate: Estimate, k: int, covariance: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3 3"]:
        """The covariance of key pose k, given that in the estimate's own frame."""
        motion = np.eye(3)
        motion[:2, 2] = self._turned(estimate.poses[k, None, :2])[0]
        common = self.with_all[3 * k : 3 * k + 3] @ motion.T
        return covariance - common - common.T + motion @ self.own @ motion.T

    def across(
        self,
        points: Float[np.ndarray, "m 2"],
        normals: Float[np.ndarray, "m 2"],
        rows: Float[np.ndarray, "m c"],
        first: int,
        variances: Float[np.ndarray, "m"],
    ) -> Float[np.ndarray, "m"]:
        """Variances of places along their normals, given those in the estimate's own frame; `rows` are the derivatives
        by the unknowns from `first` on."""
        motion = np.column_stack([normals, (normals * self._turned(points)).sum(1)])
        common = rows @ self.with_all[first : first + rows.shape[1]]
        return variances - 2.0 * (common * motion).sum(1) + np.einsum("mi,ij,mj->m", motion, self.own, motion)

    def _turned(self, points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m 2"]:
        """How points move (m/rad) when the world turns about the middle."""
        arms = points - self.middle
        return np.column_stack([-arms[:, 1], arms[:, 0]])
