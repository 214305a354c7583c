"""What beams leave over: how far each ends from the curve nearest to it, and the noise that this tells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.fitting import FittingConfig
from bspline_slam.lab.crispness import CRISP, Crispness, nearest_curves
from bspline_slam.lab.wall_beams import WallBeams
from bspline_slam.observation import across_sigma
from bspline_slam.sights import Sights, find_feet
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import SplineMap

STEEP = 0.95
"""Least cosine between a beam and the normal of its curve at which the noise of the bearing hardly shows."""
LEAST_BEAMS = 200
"""Fewer beams than these tell no noise."""
MAD_TO_SIGMA = 1.4826
"""Standard deviation of a Gaussian whose median absolute deviation is 1."""


@dataclass(frozen=True, eq=False, slots=True)
class BeamResiduals:
    """The beams that end beside a curve of the map, no farther than CRISP, sorted by spline.

    `spline` is a position in the map and `t` the parameter of the foot on it; `across` (m) is how far the beam ends in
    front of the curve (negative: behind it), `sigma` (m) the standard deviation expected of that, `cosine` that of the
    angle between the beam and the curve's normal. `crispness` is of all beams on walls.
    """

    spline: Int[np.ndarray, "m"]
    t: Float[np.ndarray, "m"]
    across: Float[np.ndarray, "m"]
    sigma: Float[np.ndarray, "m"]
    cosine: Float[np.ndarray, "m"]
    crispness: Crispness

    @classmethod
    def from_snapshot(cls, snapshot: Snapshot, fitting: FittingConfig) -> BeamResiduals:
        """Of all key scans against the map, with the noise that `fitting` assumes."""
        beams = WallBeams.from_key_scans(snapshot.observations, snapshot.poses[snapshot.key_scans])
        return cls.of(beams, snapshot.map, fitting)

    @classmethod
    def of(cls, beams: WallBeams, splines: SplineMap, fitting: FittingConfig) -> BeamResiduals:
        """Of these beams against a map."""
        distance, owner = nearest_curves(beams, splines)
        near = np.flatnonzero(distance < CRISP)
        order = near[np.argsort(owner[near], kind="stable")]
        pose, directions, ranges = beams.pose[order], beams.directions[order], beams.ranges[order]
        piece, points = np.zeros(len(order), np.int64), beams.points[order]
        sights = Sights(owner[order], pose, piece, beams.beam[order], points, directions, ranges)
        feet = find_feet(sights, splines, beams.poses, CRISP)
        normals = se2.rotate(-beams.poses[pose], feet.normals)
        sigma = across_sigma(normals, directions, ranges, fitting)
        cosine = np.abs((normals * directions).sum(1))
        met = feet.counts
        return cls(sights.spline[met], feet.t[met], feet.across[met], sigma[met], cosine[met], Crispness.of(distance))

    @property
    def range_noise(self) -> float | None:
        """Standard deviation (m) of ranges: of steep beams, robust against clutter; None where too few are steep."""
        steep = self.cosine > STEEP
        if np.count_nonzero(steep) < LEAST_BEAMS:
            return None
        return robust_sigma(self.across[steep] / self.cosine[steep])

    @property
    def spread(self) -> float | None:
        """Standard deviation of all residuals over that expected: 1 where the noise assumed is right; None where there
        are too few."""
        return None if len(self.across) < LEAST_BEAMS else robust_sigma(self.across / self.sigma)


def robust_sigma(values: Float[np.ndarray, "n"]) -> float:
    """Standard deviation by the median absolute deviation."""
    return float(MAD_TO_SIGMA * np.median(np.abs(values - np.median(values))))
