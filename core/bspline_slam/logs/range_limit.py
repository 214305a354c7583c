"""The range from which on a reading means that nothing came back, for logs that do not say it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

SICK_LIMITS = ((8.183, 8.191), (16.375, 16.383), (32.759, 32.767), (81.83, 81.91))
"""Error codes of SICK scanners (m): the largest values of 13-, 14- and 15-bit millimetres and 13-bit centimetres."""

_ROUND_LIMITS = (8.0, 10.0, 16.0, 20.0, 25.0, 30.0, 32.0, 40.0, 50.0, 60.0, 80.0, 81.9, 100.0)
_LEAST_LIMIT = 3.0  # no laser scanner sees less far (m)
_LEAST_ANNOUNCED = 0.5  # what a log announces below this is a mistake (m)
_TOLERANCE = 1e-6


def range_limit(scans: Sequence[Float[np.ndarray, "_"]], announced: float | None) -> float:
    """The no-return limit (m) of a sample of scans: readings at or above it count as no return.

    The rule: the largest reading that *stands out*, or the log's own limit where that is smaller and its readings do
    not contradict it (at most 1 % lie between the two). A value stands out when hardly any reading is larger and it
    comes far more often than its neighbours: three times at the limit of a known sensor, else in 1 % to 50 % of all
    readings and on many different beams (a far wall seen from one place repeats on few). Error codes of one sensor
    count as one value, the first of them. Where neither gives a limit, the next limit of a SICK scanner above all
    readings.
    """
    readings = np.concatenate([np.zeros(0), *scans])
    beams = np.concatenate([np.zeros(0, dtype=int), *(np.arange(len(scan)) for scan in scans)])
    usable = np.isfinite(readings) & (readings > 0)
    readings, beams = _with_codes_joined(readings[usable]), beams[usable]
    limit = float("inf")
    top = _outstanding(readings, beams, known=True)
    while top is not None:
        limit = top
        top = _outstanding(readings[readings < limit], beams[readings < limit], known=False)
    if announced is not None and _LEAST_ANNOUNCED <= announced < limit:
        beyond = np.count_nonzero((readings > announced + _TOLERANCE) & (readings < limit))
        limit = announced if beyond <= 0.01 * len(readings) else limit
    if np.isfinite(limit):
        return float(_with_codes_joined(np.array([limit]))[0])
    largest = float(readings.max(initial=0.0))
    return next((low for low, _ in SICK_LIMITS if low > largest), float(np.nextafter(largest, np.inf)))


def _outstanding(readings: Float[np.ndarray, "n"], beams: Int[np.ndarray, "n"], known: bool) -> float | None:
    """The largest reading with hardly anything above it, if it stands out; `known` admits rarer limits of sensors."""
    if len(readings) == 0:
        return None
    values, counts = np.unique(readings, return_counts=True)
    above = np.cumsum(counts[::-1])[::-1] - counts
    candidates = np.flatnonzero((above <= 0.1 * counts) & (counts >= 3) & (values >= _LEAST_LIMIT))
    for best in candidates[::-1][:8]:
        value, count = values[best], counts[best]
        near = counts[(values >= 0.8 * value) & (values < value)]
        if count < 5 * (np.median(near) if len(near) else 0):
            continue
        spread = len(np.unique(beams[readings == value]))
        common = 0.01 * len(readings) <= count <= 0.5 * len(readings) and spread >= max(5, 0.1 * (beams.max() + 1))
        if (known and _is_known(float(value))) or (common and count >= 20):
            return float(value)
    return None


def _is_known(value: float) -> bool:
    coded = any(low - _TOLERANCE <= value <= high + _TOLERANCE for low, high in SICK_LIMITS)
    return coded or any(abs(value - limit) <= _TOLERANCE for limit in _ROUND_LIMITS)


def _with_codes_joined(readings: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
    """The readings, each error code replaced by the first code of its sensor."""
    out = readings.copy()
    for low, high in SICK_LIMITS:
        out[(readings >= low - _TOLERANCE) & (readings <= high + _TOLERANCE)] = low
    return out
