"""The editor's process, seen from the page: it holds a result ready, so that an edit is answered at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from bspline_slam.edits.edit import Edit
from bspline_slam.slam import SlamConfig
from splinescope.computing.edit_messages import FindPreview, HandOver, MakeEdits, MatchLoop, Prepare
from splinescope.computing.messages import Message
from splinescope.computing.worker import Worker


class Editor(Worker):
    """Hands edits to a process that does nothing else, and that a person waits for; each method returns the number of
    its job."""

    def __init__(self, post: Callable[[Message], None]) -> None:
        super().__init__(post, "splinescope.computing.edit_jobs", niceness=0)

    def prepare(self, kept: bytes, config: SlamConfig) -> int:
        """Get ready for edits of a result."""
        return self._ask(Prepare(self._job + 1, kept, config))

    def preview(self, in_force: tuple[Edit, ...], proposed: tuple[Edit, ...]) -> int:
        """Ask what edits would do."""
        return self._ask(FindPreview(self._job + 1, in_force, proposed))

    def make(self, edits: tuple[Edit, ...], shown: tuple[Edit, ...]) -> int:
        """Ask for the result with these edits, where it is shown with others."""
        return self._ask(MakeEdits(self._job + 1, edits, shown))

    def match(self, in_force: tuple[Edit, ...], earlier: int, scan: int, guess: Float[np.ndarray, "3"]) -> int:
        """Ask how two key scans lie to each other."""
        return self._ask(MatchLoop(self._job + 1, in_force, earlier, scan, guess))

    def hand_over(self, edits: tuple[Edit, ...]) -> int:
        """Ask for the result with these edits as the estimator takes it."""
        return self._ask(HandOver(self._job + 1, edits))
