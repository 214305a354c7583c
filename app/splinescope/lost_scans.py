"""Scans that fit nowhere: how many and which, and what was done instead, in words."""

from __future__ import annotations

from collections.abc import Sequence

MOST_RUNS = 12
"""More stretches of lost scans than these are not listed."""


def lost_in_words(lost: Sequence[int], odometry: bool) -> str:
    """One or two sentences on the lost scans (indices of the log, increasing); `odometry` says whether there is any."""
    if not lost:
        return "No scan was lost: each fitted what had been seen before it."
    count = "1 scan was" if len(lost) == 1 else f"{len(lost):,} scans were"
    instead = "odometry was trusted" if odometry else "the motion before was taken to go on"
    return (
        f"{count} lost, for too few of the beams came back or fitted what had been seen: {listed(lost)}. "
        f"There {instead}, and nothing of these scans entered the map."
    )


def listed(scans: Sequence[int]) -> str:
    """Numbers in words, neighbours as one stretch: `3, 7–9, 12`."""
    stretches = runs(scans)
    said = ", ".join(f"{a:,}" if a == b else f"{a:,}–{b:,}" for a, b in stretches[:MOST_RUNS])
    unsaid = len(stretches) - MOST_RUNS
    return f"{said} and {unsaid:,} more stretches" if unsaid > 0 else said


def runs(scans: Sequence[int]) -> list[tuple[int, int]]:
    """First and last of each stretch of neighbouring numbers, which are increasing."""
    found: list[tuple[int, int]] = []
    for scan in scans:
        if found and scan == found[-1][1] + 1:
            found[-1] = (found[-1][0], scan)
        else:
            found.append((scan, scan))
    return found


def next_lost(lost: Sequence[int], cursor: int) -> int | None:
    """The first scan of the next stretch after the cursor's, from the start again after the last; None without any."""
    starts = [first for first, last in runs(lost) if not first <= cursor <= last] or [first for first, _ in runs(lost)]
    return next((first for first in starts if first > cursor), starts[0] if starts else None)
