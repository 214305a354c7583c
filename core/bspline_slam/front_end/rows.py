"""Poses that come one by one and are asked for all at once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float


class Rows:
    """A list of poses (x, y, θ) with room to grow, so that it becomes an array without a look at every pose."""

    def __init__(self, poses: Float[np.ndarray, "n 3"] | None = None) -> None:
        self._room = np.zeros((16, 3)) if poses is None else np.array(poses, dtype=float)
        self._count = 0 if poses is None else len(poses)

    def append(self, pose: Float[np.ndarray, "3"]) -> None:
        """One more pose at the end."""
        if self._count == len(self._room):
            self._room = np.concatenate([self._room, np.zeros((max(len(self._room), 16), 3))])
        self._room[self._count] = pose
        self._count += 1

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, index: int | slice) -> Float[np.ndarray, "*n 3"]:
        """A copy of one pose, or of several."""
        return self._room[: self._count][index].copy()

    def __iter__(self) -> Iterator[Float[np.ndarray, "3"]]:
        return iter(self[:])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Float[np.ndarray, "n 3"]:
        return self[:].astype(dtype or float, copy=False)
