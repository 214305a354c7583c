"""Curves that run beside each other: which places of one lie along another that faces the same way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.curve_samples import CurveSamples

AGREEMENT = 0.9
"""Least cosine between the normals of curves that run alike: the two faces of a thin wall do not."""
NEIGHBOURS = 4
"""Of so many curves near a place, the nearest, each is looked at."""


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
    near = samples.facing(
        samples.points, samples.normals, float(np.hypot(within, samples.spacing)), AGREEMENT, NEIGHBOURS
    )
    first, column = np.nonzero((near >= 0) & (samples.owner[near] != samples.owner[:, None]))
    second = near[first, column]
    across, along = samples.apart(samples.points[first], second)
    kept = (np.abs(across) < within) & (np.abs(along) < samples.spacing)
    return Alongside(first[kept], second[kept], across[kept])
