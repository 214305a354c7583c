"""How good a trajectory is: figures of relation errors, absolute trajectory error (ATE), relative pose error (RPE)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.errors import SplineSlamError
from bspline_slam.export.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Figures:
    """Mean, standard deviation, root mean square and maximum of errors that are not negative."""

    mean: float
    std: float
    rms: float
    maximum: float

    @classmethod
    def of(cls, errors: Float[np.ndarray, "n"]) -> Figures:
        """Figures of at least one error; the standard deviation is that of the sample itself (divided by n)."""
        rms = float(np.sqrt(np.mean(errors**2)))
        return cls(float(np.mean(errors)), float(np.std(errors)), rms, float(np.max(errors)))


@dataclass(frozen=True, eq=False, slots=True)
class TrajectoryErrors:
    """A trajectory against a reference, pose by pose of the reference that lies inside the trajectory.

    `absolute_*`: after the rigid alignment of all positions that is best in the least-squares sense (ATE; m, rad).
    `relative_*`: of the motion from each pose to the first one at least `distance` (m) of path later (RPE; m, rad).
    """

    compared: int
    left_out: int
    distance: float
    absolute_translation: Float[np.ndarray, "n"]
    absolute_rotation: Float[np.ndarray, "n"]
    relative_translation: Float[np.ndarray, "m"]
    relative_rotation: Float[np.ndarray, "m"]

    @classmethod
    def from_trajectories(
        cls, estimate: Trajectory, reference: Trajectory, *, distance: float = 1.0
    ) -> TrajectoryErrors:
        """Compare at the stamps of the reference; raises SplineSlamError when fewer than two of them are covered."""
        poses = estimate.at(reference.stamps)
        covered = np.isfinite(poses).all(1)
        if covered.sum() < 2:
            raise SplineSlamError(
                f"the trajectory covers {covered.sum()} of the {len(reference)} stamps of the reference: "
                "are both on one clock?"
            )
        poses, truth = poses[covered], reference.poses[covered]
        aligned = se2.compose(alignment(poses[:, :2], truth[:, :2]), poses)
        first, second = pairs_along(truth, distance)
        motion = se2.between(se2.between(truth[first], truth[second]), se2.between(poses[first], poses[second]))
        return cls(
            compared=len(poses),
            left_out=int((~covered).sum()),
            distance=distance,
            absolute_translation=np.linalg.norm(aligned[:, :2] - truth[:, :2], axis=1),
            absolute_rotation=np.abs(se2.wrap(aligned[:, 2] - truth[:, 2])),
            relative_translation=np.linalg.norm(motion[:, :2], axis=1),
            relative_rotation=np.abs(motion[:, 2]),
        )


def alignment(points: Float[np.ndarray, "n 2"], targets: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "3"]:
    """The pose T that minimises Σ‖T ⊕ point − target‖² (Umeyama 1991 in the plane, without scale)."""
    a, b = points - points.mean(0), targets - targets.mean(0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    turned = se2.transform(np.array([0.0, 0.0, angle]), points.mean(0))
    return np.array([*(targets.mean(0) - turned), angle])


def pairs_along(poses: Float[np.ndarray, "n 3"], distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Indices of each pose and of the first one at least `distance` (m) of path later, as far as there is one."""
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1))])
    second = np.searchsorted(path, path + distance)
    first = np.flatnonzero(second < len(poses))
    return first, second[first]
