"""Results with edits that are remembered, so that more edits go on from where the edits before them led."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

from bspline_slam.edits.edit import Edit
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.ties import Ties
from bspline_slam.slam import SlamConfig, Snapshot

Edits = tuple[Edit, ...]
KEPT = 12
"""So many results are remembered beside that without edits."""


@dataclass(frozen=True, eq=False, slots=True)
class Amended:
    """The result with edits, of each edit why it could not be made (None: it was made), and the ground that more edits
    start from."""

    snapshot: Snapshot
    skipped: tuple[str | None, ...]
    ground: Ground


class States:
    """State: an automatic result, the latest results with edits that were made of it, by these edits, and what was made
    of edits of ties."""

    def __init__(self, base: Snapshot, config: SlamConfig) -> None:
        """Raises SolverError for a result that was never adjusted."""
        self.base, self.config, self.ties = base, config, Ties()
        self._without = Amended(base, (), Ground.of(base, config))
        self._made: OrderedDict[Edits, Amended] = OrderedDict()

    def __contains__(self, edits: Edits) -> bool:
        return not edits or edits in self._made

    def __getitem__(self, edits: Edits) -> Amended:
        """The result with these edits. Raises KeyError where it is not remembered."""
        if not edits:
            return self._without
        self._made.move_to_end(edits)
        return self._made[edits]

    def __setitem__(self, edits: Edits, made: Amended) -> None:
        """Remember this; what nobody asked for longest is forgotten."""
        self._made[edits] = made
        self._made.move_to_end(edits)
        while len(self._made) > KEPT:
            self._made.popitem(last=False)

    def nearest(self, edits: Edits) -> Edits:
        """The longest beginning of these edits that is remembered."""
        return next(edits[:size] for size in range(len(edits), -1, -1) if edits[:size] in self)
