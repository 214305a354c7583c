"""What the page and Python tell each other, as values: what is seen, and what the timeline shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

Bounds = tuple[float, float, float, float]
"""A rectangle of the world: x_min, y_min, x_max, y_max (m)."""


class Mark(NamedTuple):
    """Something to find again on the timeline: `kind` is "key" (scan), "loop" (closure) or "lost"."""

    position: int
    kind: str


@dataclass(frozen=True, slots=True)
class TimelineState:
    """What the timeline shows: the scan under the cursor, how many there are, how many are processed already.

    `speed` multiplies real time. `label` is a few words beside the counter, such as the time of the scan. Pass the same
    `marks` object while it does not change: it is sent only when it is another one.
    """

    index: int
    length: int
    processed: int
    playing: bool = False
    speed: float = 1.0
    label: str = ""
    marks: tuple[Mark, ...] = ()


@dataclass(frozen=True, slots=True)
class Viewport:
    """What one page sees: the centre in the world (m), metres per (CSS) pixel, and its size in pixels."""

    x: float
    y: float
    metres_per_pixel: float
    width: float
    height: float

    @property
    def bounds(self) -> Bounds:
        """The rectangle of the world that is visible."""
        half_x, half_y = 0.5 * self.width * self.metres_per_pixel, 0.5 * self.height * self.metres_per_pixel
        return self.x - half_x, self.y - half_y, self.x + half_x, self.y + half_y
