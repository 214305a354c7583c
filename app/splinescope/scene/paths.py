"""Long paths made short: the vertices that the eye would miss."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int


def simplified(points: Float[np.ndarray, "n 2"], tolerance: float) -> Float[np.ndarray, "m 2"]:
    """The path without vertices that lie within `tolerance` of what is left."""
    ends = np.zeros(len(points), dtype=bool)
    ends[[0, -1] if len(points) else []] = True
    return points[needed(points, ends, tolerance)]


def needed(points: Float[np.ndarray, "n 2"], ends: Bool[np.ndarray, "n"], tolerance: float) -> Int[np.ndarray, "m"]:
    """Indices of the vertices to keep of many polylines, one after another, so that every vertex lies within
    `tolerance` of what is left of its own; the `ends` of the polylines stay.

    Every second vertex is looked at, all at once, until none can go. What is left out of a stretch is never farther
    from it than from the stretch before plus the step between the two.
    """
    kept, left_out = np.arange(len(points)), np.zeros(len(points))
    first, idle = 0, 0
    while idle < 2:
        middle = np.arange(1 + first, len(kept) - 1, 2)
        middle = middle[~ends[kept[middle]]]
        away = _from_chord(*(points[kept[middle + by]] for by in (-1, 0, 1)))
        away += np.maximum(left_out[middle - 1], left_out[middle])
        gone = middle[away <= tolerance]
        left_out[gone - 1] = away[away <= tolerance]
        kept, left_out = np.delete(kept, gone), np.delete(left_out, gone)
        first, idle = 1 - first, 0 if len(gone) else idle + 1
    return kept


def _from_chord(
    before: Float[np.ndarray, "k 2"], point: Float[np.ndarray, "k 2"], after: Float[np.ndarray, "k 2"]
) -> Float[np.ndarray, "k"]:
    chord, off = after - before, point - before
    square = np.einsum("ij,ij->i", chord, chord)
    foot = np.clip(np.einsum("ij,ij->i", off, chord) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.linalg.norm(off - foot[:, None] * chord, axis=1)
