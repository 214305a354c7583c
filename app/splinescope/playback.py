"""The clock of the timeline: which scan is shown at what time, as a value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0)
"""Multiples of real time that the speed keys step through."""

LONGEST_WAIT = 2.0
"""Pauses of the recording longer than this (s) are not waited for."""


def play_axis(times: Float[np.ndarray, "scans"]) -> Float[np.ndarray, "scans"]:
    """When each scan comes up in play at speed 1 (s, from 0): its time in the log without the long pauses."""
    return np.concatenate([[0.0], np.cumsum(np.clip(np.diff(times), 1e-6, LONGEST_WAIT))])[: len(times)]


@dataclass(frozen=True, eq=False, slots=True)
class Playback:
    """A place on an axis of play that moves at `speed` while `playing`.

    `axis` is strictly increasing, one entry per scan (s). `position` (s on that axis) was true at `stamp` (s, any
    steady clock). A viewer that is too slow therefore leaves scans out and never falls behind.
    """

    axis: Float[np.ndarray, "scans"] = field(default_factory=lambda: np.zeros(0))
    position: float = 0.0
    playing: bool = False
    speed: float = 1.0
    stamp: float = 0.0

    @property
    def count(self) -> int:
        return len(self.axis)

    @property
    def cursor(self) -> int:
        """Index of the scan to show; 0 for an empty log."""
        return max(int(np.searchsorted(self.axis, self.position, side="right")) - 1, 0)

    @property
    def at_end(self) -> bool:
        return self.cursor >= self.count - 1

    def advanced(self, now: float) -> Playback:
        """The clock at `now`; playing stops on the last scan."""
        if not self.playing or not self.count:
            return replace(self, playing=False, stamp=now)
        position = self.position + max(now - self.stamp, 0.0) * self.speed
        last = float(self.axis[-1])
        return replace(self, position=min(position, last), playing=position < last, stamp=now)

    def seek(self, index: int, now: float) -> Playback:
        """At scan `index`, kept inside the log; goes on playing if it was."""
        if not self.count:
            return replace(self, stamp=now)
        return replace(self, position=float(self.axis[min(max(index, 0), self.count - 1)]), stamp=now)

    def step(self, by: int, now: float) -> Playback:
        """`by` scans further (or back), standing still."""
        return replace(self.seek(self.cursor + by, now), playing=False)

    def play(self, now: float) -> Playback:
        """Playing; from the start when it stands at the end."""
        return replace(self, position=0.0 if self.at_end else self.position, playing=self.count > 1, stamp=now)

    def pause(self, now: float) -> Playback:
        return replace(self.advanced(now), playing=False)

    def toggled(self, now: float) -> Playback:
        return self.pause(now) if self.playing else self.play(now)

    def with_speed(self, speed: float, now: float) -> Playback:
        """The same place at another speed, kept inside what SPEEDS offers."""
        return replace(self.advanced(now), speed=float(min(max(speed, SPEEDS[0]), SPEEDS[-1])))

    def faster(self, by: int, now: float) -> Playback:
        """The next speed of SPEEDS up (by > 0) or down."""
        nearest = min(range(len(SPEEDS)), key=lambda i: abs(SPEEDS[i] - self.speed))
        return self.with_speed(SPEEDS[min(max(nearest + by, 0), len(SPEEDS) - 1)], now)
