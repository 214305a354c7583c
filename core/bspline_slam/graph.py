"""The least-squares problem as a value: derived from segments, associations and the map, never edited.

Unknowns are the poses of the key scans (n, 3) and the control points of all splines, stacked (N, 2). Every
residual is written whitened, so the cost is ½ Σ ρ(‖e‖²) and χ² = Σ ‖e‖².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.bspline import BSpline

Kernel = float | None
"""None: plain least squares. c: Cauchy, ρ(s) = c² log(1 + s/c²) of the squared norm s of the whitened residual."""


def square_root(information: Float[np.ndarray, "*batch d d"]) -> Float[np.ndarray, "*batch d d"]:
    """R with RᵀR = information, whatever its rank."""
    values, vectors = np.linalg.eigh(0.5 * (information + information.swapaxes(-1, -2)))
    return np.sqrt(np.maximum(values, 0.0))[..., None] * vectors.swapaxes(-1, -2)


@dataclass(frozen=True, eq=False, slots=True)
class SplineFactor:
    """One observation of consecutive control points c_first … c_first+m−1 from one pose.

    e(T, X) = A · vec(Rᵀ(c_i − x)) − b, with vec = (q_1x, q_1y, q_2x, …) and A (r, 2m), b (r,), whitened.
    `readings` is how many beams it sums up (none: it only fixes the parametrisation of a curve) and `constant` the
    part of χ² that no state can remove.
    """

    pose: int
    first: int
    A: Float[np.ndarray, "r d"]
    b: Float[np.ndarray, "r"]
    readings: int = 0
    constant: float = 0.0

    def residual(
        self, pose: Float[np.ndarray, "3"], control_points: Float[np.ndarray, "m 2"]
    ) -> Float[np.ndarray, "r"]:
        """e of the observing pose and the m observed control points, both in the world frame."""
        points_robot = (control_points - pose[:2]) @ se2.rotation(pose[2])
        return self.A @ points_robot.ravel() - self.b

    def jacobians(
        self, pose: Float[np.ndarray, "3"], control_points: Float[np.ndarray, "m 2"]
    ) -> tuple[Float[np.ndarray, "r 3"], Float[np.ndarray, "r d"]]:
        """∂e/∂(x, y, θ) and ∂e/∂vec(c): ∂q_i/∂c_i = Rᵀ = −∂q_i/∂x, ∂q_i/∂θ = (q_iy, −q_ix)."""
        turn, count = se2.rotation(pose[2]), len(control_points)
        points_robot = (control_points - pose[:2]) @ turn
        by_point = self.A.reshape(-1, count, 2) @ turn.T
        by_turn = self.A @ (points_robot[:, ::-1] * (1.0, -1.0)).ravel()
        return np.column_stack([-by_point.sum(axis=1), by_turn]), by_point.reshape(self.A.shape)


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

    def residual(self, pose_i: Float[np.ndarray, "3"], pose_j: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3"]:
        """e of the two poses in the world frame."""
        return self.sqrt_information @ se2.between(self.measured, se2.between(pose_i, pose_j))

    def jacobians(
        self, pose_i: Float[np.ndarray, "3"], pose_j: Float[np.ndarray, "3"]
    ) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3 3"]]:
        """∂e/∂(x_i, y_i, θ_i) and ∂e/∂(x_j, y_j, θ_j)."""
        turn = se2.rotation(-pose_i[2] - self.measured[2])
        x, y = turn @ (pose_j[:2] - pose_i[:2])
        by_i, by_j = np.zeros((3, 3)), np.eye(3)
        by_i[:2, :2], by_i[:2, 2], by_i[2, 2] = -turn, (y, -x), -1.0
        by_j[:2, :2] = turn
        return self.sqrt_information @ by_i, self.sqrt_information @ by_j


@dataclass(frozen=True, eq=False, slots=True)
class PosePrior:
    """An absolute pose: e = sqrt_information · (x_i − mean_xy, wrap(θ_i − mean_θ))."""

    pose: int
    mean: Float[np.ndarray, "3"]
    sqrt_information: Float[np.ndarray, "3 3"]

    def residual(self, pose: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3"]:
        """e of the pose; its Jacobian is `sqrt_information`."""
        difference = pose - self.mean
        return self.sqrt_information @ np.append(difference[:2], se2.wrap(difference[2]))


@dataclass(frozen=True, eq=False, slots=True)
class ShapePrior:
    """A linear statement on consecutive control points of one spline in the world: e = A · vec(c) − b, A (r, 2m)."""

    first: int
    A: Float[np.ndarray, "r d"]
    b: Float[np.ndarray, "r"]

    def residual(self, control_points: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "r"]:
        """e of the m control points in the world frame; its Jacobian is `A`."""
        return self.A @ control_points.ravel() - self.b


@dataclass(frozen=True, eq=False, slots=True)
class Beams:
    """The single beams that the spline factors sum up, for back ends that measure ranges along them.

    `spline` is a position among the graph's splines and `parameters` where on its curve the beam's foot lies. Origins
    and directions (unit) are in the robot frame; `sigma` is the standard deviation of the range (m), that of the
    bearing included. `curves` are the splines at the starting values.
    """

    pose: Int[np.ndarray, "m"]
    spline: Int[np.ndarray, "m"]
    origins: Float[np.ndarray, "m 2"]
    directions: Float[np.ndarray, "m 2"]
    ranges: Float[np.ndarray, "m"]
    parameters: Float[np.ndarray, "m"]
    sigma: Float[np.ndarray, "m"]
    curves: tuple[BSpline, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Graph:
    """The whole problem and its starting values.

    `spline_ids[k]` owns the control points `spline_first[k] : spline_first[k + 1]` (so `spline_first` has one
    entry more).
    `key_scans[i]` is the index of the scan that pose i belongs to. `beams` are the raw readings behind
    `spline_factors`; most back ends have no use for them.
    """

    key_scans: Int[np.ndarray, "n"]
    poses: Float[np.ndarray, "n 3"]
    spline_ids: Int[np.ndarray, "s"]
    spline_first: Int[np.ndarray, "s1"]
    control_points: Float[np.ndarray, "N 2"]
    spline_factors: Sequence[SplineFactor] = ()
    pose_factors: tuple[PoseFactor, ...] = ()
    pose_priors: tuple[PosePrior, ...] = ()
    shape_priors: tuple[ShapePrior, ...] = ()
    beams: Beams | None = None

    @property
    def unknowns(self) -> int:
        return 3 * len(self.poses) + 2 * len(self.control_points)
