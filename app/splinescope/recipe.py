"""What a person chooses before a run: observation model, estimator, order and knots of the curves."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bspline_slam.backends import BACK_ENDS
from bspline_slam.fitting import FittingConfig
from bspline_slam.models.chord_length import ChordLengthConfig
from bspline_slam.observation import MODELS
from bspline_slam.slam import SlamConfig

ORDERS = (2, 3, 4, 5, 6)
"""Orders of curves that can be chosen: the order is the degree plus one."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """The choices; everything else about a run is the default configuration.

    `spacing` (m) is that of the knots with "normal-distance", `control_points` the number of every spline with
    "chord-length"; the other model does not ask for it.
    """

    model: str = MODELS[0]
    back_end: str = BACK_ENDS[0]
    order: int = FittingConfig().degree + 1
    spacing: float = FittingConfig().spacing
    control_points: int = ChordLengthConfig().control_points

    def config(self) -> SlamConfig:
        """The whole configuration."""
        return SlamConfig(
            back_end=self.back_end,
            model=self.model,
            fitting=replace(FittingConfig(), degree=self.order - 1, spacing=self.spacing),
            chord_length=replace(ChordLengthConfig(), control_points=self.control_points),
        )

    @property
    def spaced(self) -> bool:
        """Whether knots are set by their distance, and not by the number of control points."""
        return self.model == MODELS[0]

    @property
    def knots(self) -> str:
        """How the knots lie, in words."""
        return f"{self.spacing:g} m apart" if self.spaced else f"{self.control_points} points each"

    def same_map(self, other: Recipe) -> bool:
        """Whether both lead to the same curves and observations, and differ at most in the estimator."""
        return (self.model, self.order, self.knots) == (other.model, other.order, other.knots)
