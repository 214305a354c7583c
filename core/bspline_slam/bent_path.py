"""A path bent so that it leads through poses that are known better."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2


def bent_through(
    path: Float[np.ndarray, "n 3"],
    places: Int[np.ndarray, "k"],
    poses: Float[np.ndarray, "k 3"],
    way: Float[np.ndarray, "n"] | None = None,
) -> Float[np.ndarray, "n 3"]:
    """The path with `poses` at its `places` (increasing indices); as it is where there are none.

    Between two of them it goes onwards from the earlier and back from the later one, blended by the share of the `way`
    gone: a measure that grows along the path, by default the number of steps. Before the first and behind the last it
    hangs on that one.
    """
    if len(places) == 0:
        return path
    index = np.arange(len(path))
    way = index.astype(float) if way is None else way
    after = np.searchsorted(places, index, side="left")
    before = np.searchsorted(places, index, side="right") - 1
    only_after, only_before = before < 0, after >= len(places)
    before, after = np.maximum(before, 0), np.minimum(after, len(places) - 1)
    onwards = se2.compose(poses[before], se2.between(path[places[before]], path))
    back = se2.compose(poses[after], se2.between(path[places[after]], path))
    length = way[places[after]] - way[places[before]]
    share = np.where(length > 0, (way - way[places[before]]) / np.where(length > 0, length, 1.0), 0.0)
    share = np.where(only_after, 1.0, np.where(only_before, 0.0, share))
    return se2.interpolate(onwards, back, share)
