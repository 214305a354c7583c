"""What beams leave over: how far each one ends beside the curve that it was given to, and the noise that this tells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.adjustment import collect_sights, find_feet
from bspline_slam.fitting import FittingConfig
from bspline_slam.observation import across_sigma
from bspline_slam.slam import Snapshot

REACH = 0.05
"""A beam that ends farther than this (m) from its curve did not see it."""
CLOSE = 0.03
"""Distance (m) within which a beam end lies on its curve."""
STEEP = 0.95
"""Least cosine between a beam and the normal of its curve at which the noise of the bearing hardly shows."""
LEAST_BEAMS = 200
"""Fewer beams than these tell no noise."""
MAD_TO_SIGMA = 1.4826
"""Standard deviation of a Gaussian whose median absolute deviation is 1."""


@dataclass(frozen=True, eq=False, slots=True)
class BeamResiduals:
    """The beams of key scans that end within REACH of the curve they were given to, sorted by spline.

    `spline` is a position in the map and `t` the parameter of the foot on it; `across` (m) is how far the beam ends in
    front of the curve (negative: behind it), `sigma` (m) the standard deviation expected of that, `cosine` that of the
    angle between the beam and the curve's normal. `points` counts all beam ends on segments of key scans, whether a curve speaks for them or not.
    """

    spline: Int[np.ndarray, "m"]
    t: Float[np.ndarray, "m"]
    across: Float[np.ndarray, "m"]
    sigma: Float[np.ndarray, "m"]
    cosine: Float[np.ndarray, "m"]
    points: int

    @classmethod
    def from_snapshot(cls, snapshot: Snapshot, fitting: FittingConfig) -> BeamResiduals:
        """Those of a map, with the noise that `fitting` assumes."""
        poses, sights = snapshot.poses[snapshot.key_scans], collect_sights(snapshot.observations, snapshot.map)
        feet = find_feet(sights, snapshot.map, poses, REACH)
        near = feet.counts
        headings = poses[sights.pose[near]] * (0.0, 0.0, -1.0)
        normals = se2.rotate(headings, feet.normals[near])
        directions = sights.directions[near]
        sigma = across_sigma(normals, directions, sights.ranges[near], fitting)
        cosine = np.abs((normals * directions).sum(1))
        points = sum(len(segment.points) for key in snapshot.observations for segment in key.segments)
        return cls(sights.spline[near], feet.t[near], feet.across[near], sigma, cosine, points)

    @property
    def rms(self) -> float:
        """Root mean square distance (m); NaN without a beam."""
        return float(np.sqrt(np.mean(self.across**2))) if len(self.across) else float("nan")

    @property
    def share_close(self) -> float:
        """Share of all beam ends on segments that lie within CLOSE of their curve; NaN without any."""
        return float(np.sum(np.abs(self.across) < CLOSE) / self.points) if self.points else float("nan")

    @property
    def range_noise(self) -> float | None:
        """Standard deviation (m) of ranges: of steep beams, robust against clutter; None where too few are steep."""
        steep = self.cosine > STEEP
        if np.count_nonzero(steep) < LEAST_BEAMS:
            return None
        return robust_sigma(self.across[steep] / self.cosine[steep])

    @property
    def scale(self) -> float | None:
        """Spread of all residuals in standard deviations expected: 1 where the noise assumed is right; None where there
        are too few."""
        return None if len(self.across) < LEAST_BEAMS else robust_sigma(self.across / self.sigma)


def robust_sigma(values: Float[np.ndarray, "n"]) -> float:
    """Standard deviation by the median absolute deviation."""
    return float(MAD_TO_SIGMA * np.median(np.abs(values - np.median(values))))
