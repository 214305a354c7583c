"""Which way odometry counts: tried on the first stretch of a log, where nothing is known yet that could tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice

import numpy as np
from jaxtyping import Float

from bspline_slam.front_end.tracking import Tracker
from bspline_slam.scan import LaserScan

SIGNS = ((1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0))
"""As it is; a laser that looks backwards; one that hangs upside down; both. The likeliest come first."""
KEY_SCANS, MOST_SCANS = 8, 1500
"""How far each is tried."""
LEAST_GAIN = 0.01
"""Beams must agree by so much better (share of 1) with another sign than with odometry as it is."""


def odometry_signs(
    log: Iterable[LaserScan], odometry: Float[np.ndarray, "scans 3"], new_tracker: Callable[[], Tracker]
) -> tuple[float, float, float]:
    """The signs of (dx, dy, dθ) with which odometry leads to scans that agree best; as they are when in doubt.

    A wrong sign is found out later too, but in a corridor, where beams leave the way along it open, the first steps
    would be taken backwards before it is.
    """
    agreement = [_agreement(log, odometry, new_tracker(), signs) for signs in SIGNS]
    return next(s for s, found in zip(SIGNS, agreement, strict=True) if found >= max(agreement) - LEAST_GAIN)


def _agreement(
    log: Iterable[LaserScan],
    odometry: Float[np.ndarray, "scans 3"],
    tracker: Tracker,
    signs: tuple[float, float, float],
) -> float:
    """Mean score of the scans that were matched; 0 where odometry is found not to fit."""
    tracker.wheels.assume(signs)
    scores: list[float] = []
    for scan in islice(log, MOST_SCANS):
        tracked = tracker.track(scan, odometry[scan.index])
        if not tracker.wheels.fit:
            return 0.0
        if tracked.key or tracked.score < 1.0:
            scores.append(0.0 if tracked.lost else tracked.score)
        if max(len(tracker.chain.keys), scores.count(0.0)) == KEY_SCANS:
            break
    return float(np.mean(scores)) if scores else 0.0
