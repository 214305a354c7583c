"""Sentences on what is unusual in a log, whatever its format."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from bspline_slam.scan import CLOCK_SET_BACK


def time_notes(stamps: Float[np.ndarray, "records"], what: str = "records") -> list[str]:
    """On steps backwards, a clock that was set back, and repeated stamps of `what` the log consists of."""
    steps = np.diff(stamps)
    notes = []
    small = steps[(steps < 0) & (steps >= -CLOCK_SET_BACK)]
    if len(small):
        notes.append(
            f"Time steps backwards {len(small)} times (by up to {-small.min():.3g} s): "
            f"the {what} keep the order of recording, and playback time never runs back."
        )
    if (back := int(np.count_nonzero(steps < -CLOCK_SET_BACK))) > 0:
        notes.append(f"The clock was set back {back} times (by up to {-steps.min():.3g} s): playback time goes on.")
    if (same := int(np.count_nonzero(steps == 0))) > 0:
        notes.append(f"{same} {what} repeat the stamp of the one before: playback spreads them evenly.")
    return notes


def beam_notes(beams: Mapping[int, int]) -> list[str]:
    """On scans with different numbers of beams (number of beams → scans)."""
    if len(beams) < 2:
        return []
    parts = ", ".join(f"{scans} with {count}" for count, scans in sorted(beams.items(), key=lambda item: -item[1])[:5])
    return [f"The number of beams changes within the log: {parts}."]


def moving_or_none(
    poses: Float[np.ndarray, "records 3"],
) -> tuple[Float[np.ndarray, "records 3"] | None, list[str]]:
    """The odometry, or None when it never moves (which is no odometry at all)."""
    if len(poses) > 1 and not np.ptp(poses, axis=0).any():
        return None, ["The odometry never moves, so it counts as missing: poses come from scan matching alone."]
    return poses, []
