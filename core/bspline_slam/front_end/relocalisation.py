"""A lost robot found again: its last key scans, taken together, are looked for on the whole map of before. A place
counts only if the scan itself fits there like a loop closure, and if the next key scan says the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.front_end.key_chain import KeyScan
from bspline_slam.front_end.loop_closure import LoopConfig, Proposal
from bspline_slam.front_end.scan_matching import MatchingConfig
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.front_end.whole_map import PlaceConfig, WholeMap, agree, last_points, proposal_at


@dataclass(frozen=True, slots=True)
class RelocalisationConfig(PlaceConfig):
    """How a lost robot is looked for. After each failure it travels on by `patience` times as far as since it was
    lost, and at least by `least_travel` (m), before the next try."""

    least_travel: float = 0.5
    patience: float = 0.5


@dataclass
class Relocaliser:
    """State of the search for one piece of the drive: the key scans from number `since` on, whose tie to those before
    is in doubt. `waiting` is a place found that wants a second opinion; `settled` says that the piece was found."""

    since: int
    config: RelocalisationConfig
    matching: MatchingConfig
    tracking: TrackingConfig
    loops: LoopConfig
    waiting: Proposal | None = None
    settled: bool = False
    _next: float = 0.0
    _map: WholeMap | None = None

    def look(
        self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], strays: Sequence[int]
    ) -> tuple[Proposal, ...]:
        """Two closures that agree on where the last key scan lies, or nothing. Key scans that are `strays` are no part
        of the map."""
        travel = keys[-1].travel - keys[self.since].travel
        if len(keys) - self.since < 3 or (self.waiting is None and travel < self._next):
            return ()
        self._next = travel + max(self.config.least_travel, self.config.patience * travel)
        before, self.waiting = self.waiting, None
        proposal = self._proposal(keys, poses, strays)
        if proposal is None or not proposal.closure.accepted:
            return ()
        if before is not None and agree(before, proposal, poses, self.config):
            self.settled = True
            return before, proposal
        self.waiting = proposal
        return ()

    def _proposal(
        self, keys: Sequence[KeyScan], poses: Float[np.ndarray, "n 3"], strays: Sequence[int]
    ) -> Proposal | None:
        """The last key scan matched at the only place of before where the piece fits."""
        c = self.config
        if self._map is None:
            known = [k for k in range(self.since) if k not in strays]
            self._map = WholeMap.of(keys, poses, known, c, self.matching)
        found = self._map.only_place(last_points(keys, poses, max(len(keys) - c.together, self.since), c), c)
        if found is None:
            return None
        args = (self.loops, self.matching, self.tracking, "lost before, found again: ")
        return proposal_at(found, keys, poses, range(self.since), *args)
