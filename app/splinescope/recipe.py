"""What a person chooses before a run: observation model, estimator, order and knots of the curves."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bspline_slam.backends import BACK_ENDS
from bspline_slam.fitting import FittingConfig
from bspline_slam.observation import MODELS
from bspline_slam.slam import SlamConfig

ORDERS = (2, 3, 4, 5, 6)
"""Orders of curves that can be chosen: the order is the degree plus one."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """The choices; everything else about a run is the default configuration. `spacing` of knots in m."""

    model: str = MODELS[0]
    back_end: str = BACK_ENDS[0]
    order: int = FittingConfig().degree + 1
    spacing: float = FittingConfig().spacing

    def config(self) -> SlamConfig:
        """The whole configuration."""
        return SlamConfig(
            back_end=self.back_end,
            model=self.model,
            fitting=replace(FittingConfig(), degree=self.order - 1, spacing=self.spacing),
        )

    @property
    def knots(self) -> str:
        """How the knots lie, in words."""
        return f"{self.spacing:g} m apart"

    def same_map(self, other: Recipe) -> bool:
        """Whether both lead to the same curves and observations, and differ at most in the estimator."""
        return replace(self, back_end=other.back_end) == other
