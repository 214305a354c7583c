"""Places seen again: candidates, verification, and the verdict on each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False, slots=True)
class LoopClosure:
    """A proposed tie between two key scans, by scan index.

    `measured` is the pose of `scan` seen from `earlier`, with `covariance`; `score` the correlation (0…1) and
    `inliers` the share of beams
    that lie on the earlier map; `accepted` the verdict and `reason` its sentence.
    """

    earlier: int
    scan: int
    measured: Float[np.ndarray, "3"]
    covariance: Float[np.ndarray, "3 3"]
    score: float
    inliers: float
    accepted: bool
    reason: str
