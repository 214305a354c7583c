"""The iterations of a solve shown again: which one is looked at, and the map as it was there."""

from __future__ import annotations

from functools import lru_cache

from bspline_slam.scan import ScanLog
from bspline_slam.slam import Snapshot
from splinescope.computing.iterations import Frame, at_frame
from splinescope.map_view import view_map
from splinescope.view import MapView

Frames = tuple[Frame, ...]


class Replay:
    """State: the iteration looked at, and its map, which is made once. The last of the frames is the result itself."""

    def __init__(self) -> None:
        self._chosen: tuple[Frames, int] = ((), 0)
        self._played = lru_cache(maxsize=1)(_played)

    def number(self, frames: Frames) -> int | None:
        """Which of these frames is shown; None for the result."""
        of, number = self._chosen
        return number if frames is of and 0 <= number < len(frames) - 1 else None

    def show(self, frames: Frames, number: int | None) -> None:
        """Show this one of them; None: the result."""
        self._chosen = (frames, len(frames) if number is None else number)

    def step(self, frames: Frames, by: int) -> None:
        """Show the one `by` further on."""
        last, now = len(frames) - 1, self.number(frames)
        self.show(frames, min(max((last if now is None else now) + by, 0), last))

    def map(self, frames: Frames, log: ScanLog, result: Snapshot) -> tuple[Snapshot, MapView] | None:
        """The result as it was at the iteration shown; None where that is the result itself."""
        number = self.number(frames)
        return None if number is None else self._played(log, result, frames[number])


def _played(log: ScanLog, result: Snapshot, frame: Frame) -> tuple[Snapshot, MapView]:
    snapshot = at_frame(result, frame)
    return snapshot, view_map(log, snapshot, {})
