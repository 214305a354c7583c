"""The beams that count, with their weights: what every term of the adjustment is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.fitting import FittingConfig
from bspline_slam.observation import across_sigma
from bspline_slam.sights import Feet, Sights


@dataclass(frozen=True, eq=False, slots=True)
class CountedBeams:
    """Of each beam that counts its `place` among all sights, the unit normal of its curve at its foot (robot frame),
    and the standard deviation of its end across the curve (m)."""

    place: Int[np.ndarray, "m"]
    normals: Float[np.ndarray, "m 2"]
    sigma: Float[np.ndarray, "m"]

    @classmethod
    def of(
        cls, sights: Sights, feet: Feet, poses: Float[np.ndarray, "n 3"], fitting: FittingConfig, outlier: float
    ) -> CountedBeams:
        """Beams that lie farther off than `outlier` standard deviations count as if they were as noisy as that."""
        place = np.flatnonzero(feet.counts)
        normals = se2.rotate(-poses[sights.pose[place]], feet.normals[place])
        sigma = across_sigma(normals, sights.directions[place], sights.ranges[place], fitting)
        return cls(place, normals, np.maximum(sigma, np.abs(feet.across[place]) / outlier))

    def only(self, chosen: Bool[np.ndarray, "m"]) -> CountedBeams:
        """The chosen ones of them."""
        return CountedBeams(self.place[chosen], self.normals[chosen], self.sigma[chosen])
