"""Level of detail: how fine to draw, and where, for what is seen just now."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from splinescope.browser.values import Bounds, Viewport

CLOSE = 0.015  # m per pixel: from here on control points of the map stand far enough apart to be told from each other
READABLE = 0.03  # m per pixel: farther away the signs on a scan would only cover each other


@dataclass(frozen=True, slots=True)
class Detail:
    """Metres per pixel, rounded to half octaves, and a rectangle around the view, rounded outwards to large tiles.

    Equal details draw the same picture: a little panning or zooming changes nothing.
    """

    pixel: float
    window: Bounds

    @classmethod
    def of(cls, viewport: Viewport) -> Detail:
        """What a page needs."""
        x_min, y_min, x_max, y_max = viewport.bounds
        tile = 2.0 ** np.ceil(np.log2(0.5 * max(x_max - x_min, y_max - y_min)))
        low = np.floor(np.array([x_min, y_min]) / tile - 0.1) * tile
        high = np.ceil(np.array([x_max, y_max]) / tile + 0.1) * tile
        pixel = 2.0 ** (np.round(2.0 * np.log2(viewport.metres_per_pixel)) / 2.0)
        return cls(float(pixel), (float(low[0]), float(low[1]), float(high[0]), float(high[1])))

    @property
    def close(self) -> bool:
        """Whether single control points of the map can be told apart."""
        return self.pixel <= CLOSE

    @property
    def readable(self) -> bool:
        """Whether the signs on a scan can be told apart."""
        return self.pixel <= READABLE

    def inside(self, points: Float[np.ndarray, "n 2"]) -> Bool[np.ndarray, "n"]:
        """Points within the window."""
        x_min, y_min, x_max, y_max = self.window
        x, y = points[:, 0], points[:, 1]
        return (x >= x_min) & (x <= x_max) & (y >= y_min) & (y <= y_max)

    @property
    def centre(self) -> Float[np.ndarray, "2"]:
        """The middle of the window (m)."""
        x_min, y_min, x_max, y_max = self.window
        return np.array([x_min + x_max, y_min + y_max]) / 2.0


OVERVIEW = Detail(0.06, (-np.inf, -np.inf, np.inf, np.inf))
"""Before any page has told what it sees."""
