"""Two cores for work that falls into pieces."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Int

LEAST = 4096
"""Less labour than this is done sooner than a thread begins."""


def in_halves(work: Callable[[int, int], object], cuts: Int[np.ndarray, "p1"]) -> None:
    """Do `work(first, last)` on the pieces up to the middle and on those behind it, at the same time.

    Piece p takes the labour cuts[p + 1] − cuts[p]. The work must be a compiled kernel that does without the lock of the
    interpreter and writes what it finds of each piece to a place of its own: then nothing hangs on which is faster.
    """
    pieces = len(cuts) - 1
    if cuts[-1] - cuts[0] < LEAST:
        work(0, pieces)
        return
    middle = int(np.searchsorted(cuts, (cuts[0] + cuts[-1]) // 2))
    with ThreadPoolExecutor(1, "half") as other:
        begun = other.submit(work, 0, middle)
        work(middle, pieces)
        begun.result()
