"""Where the beams of a scan point when the log only says how many there are."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from jaxtyping import Float

_HALF_TURN_COUNTS = (90, 91, 180, 181, 360, 361, 720, 721)
_OTHER_SENSORS = {
    # beams: (first bearing, step), degrees
    101: (-50.0, 1.0),  # SICK LMS in its 100° mode
    201: (-50.0, 0.5),
    401: (-50.0, 0.25),
    270: (-135.0, 1.0),  # 270° scanners: SICK S300, LMS1xx, TiM and Hokuyo UTM
    271: (-135.0, 1.0),
    540: (-135.0, 0.5),
    541: (-135.0, 0.5),
    811: (-135.0, 1.0 / 3.0),
    1080: (-135.0, 0.25),
    1081: (-135.0, 0.25),
    681: (-119.53125, 360.0 / 1024.0),  # Hokuyo URG-04LX: 240° of a 1024-step turn
    682: (-119.8828125, 360.0 / 1024.0),
    683: (-119.8828125, 360.0 / 1024.0),
    726: (-127.6171875, 360.0 / 1024.0),
}


@lru_cache(maxsize=8)
def bearings_of_count(beams: int) -> Float[np.ndarray, "beams"]:
    """Bearings (rad) of `beams` readings of a laser that does not say its field of view.

    Even counts that divide a half turn leave out its last beam (180 → −90…+89°, 360 → −90…+89.5°), odd ones have
    both ends (181 → −90…+90°, 361 likewise); the counts of some other sensors are known; the rest cover a half turn.
    All scans of a log share the array, which nobody may write to.
    """
    if beams in _OTHER_SENSORS:
        first, step = _OTHER_SENSORS[beams]
    else:
        first, step = -90.0, 180.0 / max(beams - beams % 2, 1)
    return np.deg2rad(first + step * np.arange(beams))


def count_is_known(beams: int) -> bool:
    """Whether the field of view for this number of beams is that of a known sensor and not a guess."""
    return beams in _OTHER_SENSORS or beams in _HALF_TURN_COUNTS
