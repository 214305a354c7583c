"""Long paths made short: the vertices that the eye would miss."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float


def simplified(points: Float[np.ndarray, "n 2"], tolerance: float) -> Float[np.ndarray, "m 2"]:
    """The path without the vertices that lie within `tolerance` of what is left (Douglas and Peucker 1973).

    Vertices that hardly moved from the one before are dropped first, so that a robot at rest costs nothing.
    """
    if len(points) < 3:
        return points
    cell = np.round(points / max(0.5 * tolerance, 1e-9))
    moved = np.append(np.any(np.diff(cell, axis=0) != 0, axis=1), True)
    moved[0] = True
    points = points[moved]
    return points[_kept(points, tolerance)]


def _kept(points: Float[np.ndarray, "n 2"], tolerance: float) -> Bool[np.ndarray, "n"]:
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    open_stretches = [(0, len(points) - 1)]
    while open_stretches:
        first, last = open_stretches.pop()
        if last - first < 2:
            continue
        chord = points[last] - points[first]
        off = points[first + 1 : last] - points[first]
        square = float(chord @ chord)
        foot = np.clip(off @ chord / square, 0.0, 1.0) if square > 0 else np.zeros(len(off))
        away = off - foot[:, None] * chord
        distance = np.einsum("ij,ij->i", away, away)
        worst = int(np.argmax(distance))
        if distance[worst] > tolerance**2:
            middle = first + 1 + worst
            keep[middle] = True
            open_stretches += [(first, middle), (middle, last)]
    return keep
