"""Results with edits that are remembered, so that more edits go on from where the edits before them led."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

from bspline_slam.edits.edit import Edit
from bspline_slam.edits.footing import Footing
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.ties import Ties
from bspline_slam.slam import SlamConfig, Snapshot

Edits = tuple[Edit, ...]
LATEST, MILESTONES, APART = 4, 6, 8
"""So many of the latest results are remembered, and so many of those with a multiple of `APART` edits: to go back far
is to make some edits anew, not all."""


@dataclass(frozen=True, eq=False, slots=True)
class Amended:
    """The result with edits, of each edit why it could not be made (None: it was made), and the ground that more edits
    start from."""

    snapshot: Snapshot
    skipped: tuple[str | None, ...]
    ground: Ground


class States:
    """State: an automatic result, some results with edits that were made of it, by these edits, what was made of edits
    of ties, and the latest footing."""

    def __init__(self, base: Snapshot, config: SlamConfig) -> None:
        """Raises SolverError for a result that was never adjusted."""
        self.base, self.config, self.ties = base, config, Ties()
        self._without = Amended(base, (), Ground.of(base, config))
        self._made: OrderedDict[Edits, Amended] = OrderedDict()
        self._footing: Footing | None = None

    def __contains__(self, edits: Edits) -> bool:
        return not edits or edits in self._made

    def __getitem__(self, edits: Edits) -> Amended:
        """The result with these edits. Raises KeyError where it is not remembered."""
        if not edits:
            return self._without
        self._made.move_to_end(edits)
        return self._made[edits]

    def keep(self, edits: Edits, made: Amended, footing: Footing) -> None:
        """Remember this; what nobody asked for longest is forgotten."""
        self._made[edits], self._footing = made, footing
        self._made.move_to_end(edits)
        for milestones, most in ((False, LATEST), (True, MILESTONES)):
            alike = [known for known in self._made if (len(known) % APART == 0) is milestones]
            for known in alike[:-most]:
                del self._made[known]

    def footing(self, edits: Edits) -> Footing:
        """The footing of the result with these edits. Raises KeyError where that is not remembered."""
        ground = self[edits].ground
        if self._footing is None or self._footing.ground is not ground:
            self._footing = Footing.of(ground)
        return self._footing

    def nearest(self, edits: Edits) -> Edits:
        """The longest beginning of these edits that is remembered."""
        return next(edits[:size] for size in range(len(edits), -1, -1) if edits[:size] in self)
