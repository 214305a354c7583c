"""Back at an earlier place: every way to find that out, and poses and map moved accordingly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends import Stopping, back_end
from bspline_slam.front_end.far_loops import FarCloser
from bspline_slam.front_end.key_chain import KeyChain
from bspline_slam.front_end.key_map import KeyMap
from bspline_slam.front_end.loop_closer import LoopCloser
from bspline_slam.front_end.loop_closure import LoopClosure, Proposal
from bspline_slam.front_end.relocalisation import Relocaliser
from bspline_slam.graph import Graph, PoseFactor, PosePrior
from bspline_slam.slam_config import SlamConfig

RELAXED_AFTER, RELAXED_SHARE = 5, 0.1
"""So many closures, and such a share of all so far, make the pose graph be solved anew though each of them says what
the estimate says already: together they say more, and the more there are the less does one of them."""


@dataclass
class Revisits:
    """State: the closures so far, how many of them the pose graph was not yet solved with, and the search for a piece
    that was lost. Closures move the key scans of `chain`, and `map` goes along."""

    config: SlamConfig
    chain: KeyChain
    map: KeyMap
    closer: LoopCloser = field(init=False)
    _far: FarCloser = field(init=False)
    _seeker: Relocaliser | None = None
    _unsolved: int = 0

    def __post_init__(self) -> None:
        c = self.config
        self.closer = LoopCloser(c.loops, c.matching, c.tracking)
        self._far = FarCloser(c.far_loops, c.matching, c.tracking, c.loops)

    @property
    def pose_factors(self) -> tuple[PoseFactor, ...]:
        """All ties between key scans: by odometry, by matching, and by closures."""
        return (*self.chain.factors, *(proposal.factor for proposal in self.closer.accepted))

    def look(self) -> tuple[LoopClosure, ...]:
        """Find out whether the last key scan is of an earlier place. Returns what was decided."""
        return (*self._find_again(), *self._close_far(), *self._close_loops())

    def finish(self) -> None:
        """What the last key scan closed, the pose graph solved, and closures that it contradicts taken back."""
        self.closer.found(self.chain.keys, np.array(self.chain.poses))
        self.relax()
        if self.closer.reject_contradicted(np.array(self.chain.poses)):
            self.relax()

    def relax(self, more: Sequence[PoseFactor] = ()) -> None:
        """The pose graph solved with all factors so far, and `more`."""
        if len(self.chain.keys) < 2:
            return
        self._unsolved = 0
        poses = np.array(self.chain.poses)
        graph = Graph(
            key_scans=np.array([key.scan for key in self.chain.keys], dtype=np.int64),
            poses=poses,
            spline_ids=np.zeros(0, dtype=np.int64),
            spline_first=np.zeros(1, dtype=np.int64),
            control_points=np.zeros((0, 2)),
            pose_factors=(*self.pose_factors, *more),
            pose_priors=(PosePrior(0, poses[0], np.eye(3) / self.config.adjustment.anchor),),
        )
        self.chain.move(back_end("pose_graph", Stopping(1e-5, 1e-4, 20)).solve(graph).poses)

    # -- steps of `look` ---------------------------------------------------------------------------------------
    def _find_again(self) -> tuple[LoopClosure, ...]:
        """Where the tie of the last key scans to those before is in doubt: look for them on the whole map; when they
        are found elsewhere, the piece goes there, and the map is read anew."""
        chain, c = self.chain, self.config
        if chain.strays and (self._seeker is None or self._seeker.since < chain.strays[-1]):
            self._seeker = Relocaliser(chain.strays[-1], c.relocalisation, c.matching, c.tracking, c.loops)
        if self._seeker is None or self._seeker.settled:
            return ()
        fresh = self._seeker.look(chain.keys, np.array(chain.poses), chain.strays)
        if fresh:
            self.closer.take(fresh, chain.keys, self._seeker.since)
            if self._disagree(fresh, np.array(chain.poses)):
                chain.untie(self._seeker.since, fresh[-1].factor, c.tracking.untied)
                self.relax()
                self.map.rebuild(np.array(chain.poses))
        return tuple(proposal.closure for proposal in fresh)

    def _close_far(self) -> tuple[LoopClosure, ...]:
        """Where the last key scans fit only one place inside an uncertainty too large for a search around them: close
        the loop there, at first whatever stands against it, and let the map go along."""
        keys, poses, closed_at = self.chain.keys, np.array(self.chain.poses), self.closer.closed_at
        fresh = self._far.look(keys, poses, self.chain.factors, self.closer)
        if fresh:
            self.relax(tuple(replace(proposal.factor, kernel=None) for proposal in fresh))
            self.closer.accept(fresh, keys)
            self.relax()
            self._carry(poses, closed_at)
        return tuple(proposal.closure for proposal in fresh)

    def _close_loops(self) -> tuple[LoopClosure, ...]:
        """Relax the pose graph where the key scan before this one closed a loop and closures say that it should move;
        begin to compare this one with earlier places."""
        keys, poses = self.chain.keys, np.array(self.chain.poses)
        before, closed_at = len(self.closer.closures), self.closer.closed_at
        fresh = self.closer.found(keys, poses)
        self._unsolved += len(fresh)
        enough = max(RELAXED_AFTER, RELAXED_SHARE * len(self.closer.accepted))
        if fresh and (self._disagree(fresh, poses) or self._unsolved >= enough):
            self.relax()
            moved = self.chain.poses[:-1][:, :2] - poses[:-1, :2]
            if np.abs(moved).max(initial=0.0) > self.config.rebuild_move:
                self._carry(poses, closed_at)
        self.closer.look(keys, np.array(self.chain.poses))
        return tuple(self.closer.closures[before:])

    def _carry(self, before: Float[np.ndarray, "n 3"], closed_at: float) -> None:
        """The map goes along with its key scans; those since the last closure (m travelled) are read anew."""
        n = len(self.map.keys)
        since = next((k for k in range(n) if self.chain.keys[k].travel > closed_at), n)
        self.map.carry(before, np.array(self.chain.poses), since)

    def _disagree(self, fresh: Sequence[Proposal], poses: Float[np.ndarray, "n 3"]) -> bool:
        """Whether a closure lies off the present estimate by more than the map's own tolerance."""
        for p in fresh:
            off = se2.between(p.closure.measured, se2.between(poses[p.i], poses[p.j]))
            if np.hypot(off[0], off[1]) > self.config.rebuild_move:
                return True
        return False
