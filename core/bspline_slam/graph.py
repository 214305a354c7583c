"""The least-squares problem as a value: derived from segments, associations and the map, never edited.

Unknowns are the poses of the key scans (n, 3) and the control points of all splines, stacked (N, 2). Every
residual is written
whitened, so the cost is ½ Σ ρ(‖e‖²) and χ² = Σ ‖e‖².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

Kernel = float | None
"""None: plain least squares. c: Cauchy, ρ(s) = c² log(1 + s/c²) of the squared norm s of the whitened residual."""


@dataclass(frozen=True, eq=False, slots=True)
class SplineFactor:
    """One observation of consecutive control points c_first … c_first+m−1 from one pose.

    e(T, X) = A · vec(Rᵀ(c_i − x)) − b, with vec = (q_1x, q_1y, q_2x, …) and A (r, 2m), b (r,), whitened.
    `readings` is how many beams it sums up and `constant` the part of χ² that no state can remove.
    """

    pose: int
    first: int
    A: Float[np.ndarray, "r 2m"]
    b: Float[np.ndarray, "r"]
    readings: int = 0
    constant: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class PoseFactor:
    """A relative pose i → j: e = sqrt_information · (R_zᵀ(R_iᵀ(x_j − x_i) − z_xy), wrap(θ_j − θ_i − z_θ)).

    `kind` is "odometry", "matching" or "loop"; `kernel` is set on loop closures.
    """

    i: int
    j: int
    measured: Float[np.ndarray, "3"]
    sqrt_information: Float[np.ndarray, "3 3"]
    kind: str = "odometry"
    kernel: Kernel = None


@dataclass(frozen=True, eq=False, slots=True)
class PosePrior:
    """An absolute pose: e = sqrt_information · (x_i − mean_xy, wrap(θ_i − mean_θ))."""

    pose: int
    mean: Float[np.ndarray, "3"]
    sqrt_information: Float[np.ndarray, "3 3"]


@dataclass(frozen=True, eq=False, slots=True)
class ShapePrior:
    """A linear statement on consecutive control points of one spline in the world: e = A · vec(c) − b, A (r, 2m)."""

    first: int
    A: Float[np.ndarray, "r 2m"]
    b: Float[np.ndarray, "r"]


@dataclass(frozen=True, eq=False, slots=True)
class Graph:
    """The whole problem and its starting values.

    `spline_ids[k]` owns the control points `spline_first[k] : spline_first[k + 1]` (so `spline_first` has one
    entry more).
    `key_scans[i]` is the index of the scan that pose i belongs to.
    """

    key_scans: Int[np.ndarray, "n"]
    poses: Float[np.ndarray, "n 3"]
    spline_ids: Int[np.ndarray, "s"]
    spline_first: Int[np.ndarray, "s1"]
    control_points: Float[np.ndarray, "N 2"]
    spline_factors: tuple[SplineFactor, ...] = ()
    pose_factors: tuple[PoseFactor, ...] = ()
    pose_priors: tuple[PosePrior, ...] = ()
    shape_priors: tuple[ShapePrior, ...] = ()

    @property
    def unknowns(self) -> int:
        return 3 * len(self.poses) + 2 * len(self.control_points)
