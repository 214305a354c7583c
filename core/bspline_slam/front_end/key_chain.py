"""The chain of key scans: their poses, what ties each to the one before, and every other scan tied to one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bent_path import bent_through
from bspline_slam.front_end.rows import Rows
from bspline_slam.front_end.scan_matching import MatchingConfig, PointSet, Surroundings, Target, gather, surroundings
from bspline_slam.graph import PoseFactor


@dataclass(frozen=True, eq=False, slots=True)
class KeyScan:
    """A scan that entered the problem: its index in the log, its beam ends, and how far the robot had travelled (m)."""

    scan: int
    points: PointSet
    travel: float


@dataclass
class KeyChain:
    """State of the chain.

    `poses` may be replaced from outside (loop closures, adjustment); everything else hangs on them: `anchors` ties each
    scan to the key scan before it, `moves` each key scan to the one before, as tracking saw them, and `factors` say how
    well. `strays` are the key scans (by number) that were lost and see another place than they should: whatever ties
    them to the one before is in doubt. The last `local_scans` make the target that the next scan is matched to.
    """

    local_scans: int
    matching: MatchingConfig
    keys: list[KeyScan] = field(default_factory=list)
    poses: Rows = field(default_factory=Rows)
    anchors: list[tuple[int, Float[np.ndarray, "3"]]] = field(default_factory=list)
    moves: list[Float[np.ndarray, "3"]] = field(default_factory=list)
    factors: list[PoseFactor] = field(default_factory=list)
    strays: list[int] = field(default_factory=list)
    _target: Target | None = None
    _surroundings: Surroundings | None = None

    def pose_of(self, scan: int) -> Float[np.ndarray, "3"]:
        """World pose of a scan (by its number among those tracked)."""
        anchor, relative = self.anchors[scan]
        return se2.compose(self.poses[anchor], relative)

    @property
    def scan_poses(self) -> Float[np.ndarray, "scans 3"]:
        """World poses of all scans so far."""
        if not self.anchors:
            return np.zeros((0, 3))
        chain = [np.zeros(3)]
        for moved in self.moves:
            chain.append(se2.compose(chain[-1], moved))
        anchor = np.array([anchor for anchor, _ in self.anchors])
        scans = se2.compose(np.array(chain)[anchor], np.array([relative for _, relative in self.anchors]))
        return bent_through(scans, np.array([key.scan for key in self.keys]), np.array(self.poses))

    @property
    def shows_nothing(self) -> bool:
        """Whether none of the last key scans shows anything that a scan could be matched to."""
        return not any(len(key.points.points) for key in self.keys[-self.local_scans :])

    def target(self) -> Target:
        """The last key scans as one target."""
        if self._target is None:
            n = self.local_scans
            self._target = gather([key.points for key in self.keys[-n:]], self.poses[-n:])
        return self._target

    def surroundings(self) -> Surroundings:
        """The same made ready for a search."""
        if self._surroundings is None:
            self._surroundings = surroundings(self.target(), self.matching)
        return self._surroundings

    def hang(self, pose: Float[np.ndarray, "3"]) -> None:
        """One more scan, tied to the last key scan."""
        self.anchors.append((len(self.keys) - 1, se2.between(self.poses[-1], pose)))

    def begin(self, scan: int, points: PointSet) -> None:
        """The first key scan, at the origin."""
        self._append(KeyScan(scan, points, 0.0), se2.IDENTITY)

    def extend(
        self,
        scan: int,
        points: PointSet,
        pose: Float[np.ndarray, "3"],
        extra_travel: float,
        factors: Sequence[PoseFactor],
    ) -> None:
        """One more key scan, tied to the one before by `factors`; `extra_travel` (m) counts beyond the way between."""
        moved = se2.between(self.poses[-1], pose)
        travel = self.keys[-1].travel + float(np.hypot(moved[0], moved[1])) + extra_travel
        self.moves.append(moved)
        self.factors.extend(factors)
        self._append(KeyScan(scan, points, travel), pose)

    def move(self, poses: Float[np.ndarray, "n 3"]) -> None:
        """Take over corrected poses of the key scans."""
        self.poses = Rows(poses)
        self._target = self._surroundings = None

    def untie(self, since: int, where: PoseFactor, sigma: float) -> None:
        """Let go of what ties key scan `since` to the one before (m, rad; 1 σ), and carry all from it on to where a
        closure puts one of them."""
        poses = np.array(self.poses)
        there = se2.compose(poses[where.i], where.measured)
        poses[since:] = se2.compose(se2.compose(there, se2.inverse(poses[where.j])), poses[since:])
        moved = se2.between(poses[since - 1], poses[since])
        self.factors = [factor for factor in self.factors if factor.j != since]
        self.factors.append(PoseFactor(since - 1, since, moved, np.eye(3) / sigma, "odometry"))
        self.move(poses)

    def _append(self, key: KeyScan, pose: Float[np.ndarray, "3"]) -> None:
        self.keys.append(key)
        self.poses.append(pose)
        self.anchors.append((len(self.keys) - 1, np.zeros(3)))
        self._target = self._surroundings = None
