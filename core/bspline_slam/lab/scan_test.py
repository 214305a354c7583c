"""A normalised square for each of some key scans, held against the band that it should lie in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.lab.statistics import chi_square_bands


@dataclass(frozen=True, eq=False, slots=True)
class ScanTest:
    """eᵀ S⁻¹ e of key scans (indices of the log, increasing) with their degrees of freedom: χ² where all is honest."""

    scans: Int[np.ndarray, "n"]
    squares: Float[np.ndarray, "n"]
    dof: Float[np.ndarray, "n"]

    @property
    def normalised(self) -> Float[np.ndarray, "n"]:
        """Squares divided by their degrees of freedom: 1 on average where all is honest."""
        return self.squares / np.maximum(self.dof, 1.0)

    @property
    def bands(self) -> Float[np.ndarray, "n 2"]:
        """Where each normalised square lies with a probability of 95 %."""
        return chi_square_bands(np.maximum(self.dof, 1.0))

    @property
    def inside(self) -> Bool[np.ndarray, "n"]:
        """Whether each lies in its band."""
        low, high = self.bands.T
        return (self.normalised >= low) & (self.normalised <= high)

    @property
    def worst(self) -> int | None:
        """The scan that lies farthest above its band, as a multiple of its upper edge; None where there is none."""
        if not len(self.scans):
            return None
        return int(self.scans[np.argmax(self.normalised / self.bands[:, 1])])
