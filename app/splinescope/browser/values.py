"""What the page and Python tell each other, as values: what is seen, and what the timeline shows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

Bounds = tuple[float, float, float, float]
"""A rectangle of the world: x_min, y_min, x_max, y_max (m)."""
Place = tuple[float, float, float]
"""What a page looks at: the middle in the world x, y (m), and metres per pixel."""


class Mark(NamedTuple):
    """Something to find again on the timeline: `kind` is "key" (scan), "loop" (closure), "lost", "new" (spline),
    "gated" (out) or "hand" (decided by hand)."""

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
    """What one page sees: the centre in the world (m), metres per (CSS) pixel, and its size in pixels.

    What is up on the screen is the world's y axis turned by `turn` (rad). `fitted`: it sees what it was made to
    see, and no person has looked elsewhere since.
    """

    x: float
    y: float
    metres_per_pixel: float
    width: float
    height: float
    turn: float = 0.0
    fitted: bool = True

    @property
    def place(self) -> Place:
        """Where it looks."""
        return self.x, self.y, self.metres_per_pixel

    @property
    def bounds(self) -> Bounds:
        """The smallest rectangle of the world that holds all that is visible."""
        wide, tall = 0.5 * self.width * self.metres_per_pixel, 0.5 * self.height * self.metres_per_pixel
        across, along = abs(math.cos(self.turn)), abs(math.sin(self.turn))
        half_x, half_y = wide * across + tall * along, wide * along + tall * across
        return self.x - half_x, self.y - half_y, self.x + half_x, self.y + half_y
