"""Hand-checked relative poses that a real log is scored on (Kümmerle et al. 2009)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.export.trajectory import Trajectory


@dataclass(frozen=True, eq=False, slots=True)
class Relations:
    """Relation i says: the pose at stamp `ends[i, 1]` seen from the pose at `ends[i, 0]` is `measured[i]`."""

    ends: Float[np.ndarray, "n 2"]
    measured: Float[np.ndarray, "n 3"]

    def __len__(self) -> int:
        return len(self.ends)

    @classmethod
    def from_file(cls, path: Path) -> Relations:
        """Read `t1 t2 x y z roll pitch yaw` lines (s, m, rad); raises LogError with the line that is none."""
        rows = []
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise LogError(path, f"is not a readable file of relations ({error})") from None
        for number, line in enumerate(lines, start=1):
            words = line.partition("#")[0].split()
            if not words:
                continue
            try:
                first, second, x, y, _, _, _, yaw = map(float, words)
            except ValueError:
                raise LogError(path, "a relation is `t1 t2 x y z roll pitch yaw`, eight numbers", number) from None
            rows.append((first, second, x, y, yaw))
        if not rows:
            raise LogError(path, "holds no relations")
        table = np.array(rows)
        return cls(table[:, :2], table[:, 2:])


@dataclass(frozen=True, eq=False, slots=True)
class RelationErrors:
    """How far a trajectory is from each relation.

    `scored` says which relations have both ends inside the trajectory, `interpolated` which of these have an end
    between two records; the errors are of the scored ones, in their order. `translation` (m) is Kümmerle's
    ‖t − t*‖; `translation_with_lever_arm` (m) is Cartographer's, which adds the rotation error times the length of
    the relation. `rotation` is |θ − θ*| (rad).
    """

    scored: Bool[np.ndarray, "n"]
    interpolated: Bool[np.ndarray, "n"]
    translation: Float[np.ndarray, "m"]
    translation_with_lever_arm: Float[np.ndarray, "m"]
    rotation: Float[np.ndarray, "m"]

    @classmethod
    def from_trajectory(cls, trajectory: Trajectory, relations: Relations) -> RelationErrors:
        """Score every relation whose two stamps lie inside the trajectory."""
        first, second = trajectory.at(relations.ends[:, 0]), trajectory.at(relations.ends[:, 1])
        scored = np.isfinite(first[:, 0] + second[:, 0])
        measured, estimated = relations.measured[scored], se2.between(first[scored], second[scored])
        error = se2.between(measured, estimated)
        with_lever_arm = se2.compose(estimated, se2.inverse(measured))
        exact = trajectory.nearest(relations.ends.ravel())[1].reshape(-1, 2).max(1) <= 1e-4
        return cls(
            scored=scored,
            interpolated=scored & ~exact,
            translation=np.linalg.norm(error[:, :2], axis=1),
            translation_with_lever_arm=np.linalg.norm(with_lever_arm[:, :2], axis=1),
            rotation=np.abs(error[:, 2]),
        )
