"""How well walls meet in the corners of a map, whether it knows them or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bspline_slam.corners import corners_of, end_crossing, ends_and_starts
from bspline_slam.spline_map import SplineMap

WITHIN = 0.1
"""Walls that both end no farther than this (m) from where they cross look like a corner."""


@dataclass(frozen=True, slots=True)
class CornerGaps:
    """Of `corners` places that look like a corner, `joined` are one: there both walls end at their crossing. `mean` and
    `percentile_95` tell how far from the crossing that of the two walls ends that does so farther off (m); NaN where
    there is none."""

    corners: int
    joined: int
    mean: float
    percentile_95: float

    @classmethod
    def of(cls, splines: SplineMap) -> CornerGaps:
        """That of a map; each end of a wall counts at one corner, the nearest."""
        gaps = np.array(nearest_gaps(splines))
        mean, worst = (float(gaps.mean()), float(np.percentile(gaps, 95))) if len(gaps) else (float("nan"),) * 2
        return cls(len(gaps), len(corners_of(splines)), mean, worst)


def nearest_gaps(splines: SplineMap) -> list[float]:
    """The distances from the crossing (m), the smallest first."""
    found = []
    for i, j in ends_and_starts(splines, 2.0 * WITHIN):
        before, after = splines.splines[i], splines.splines[j]
        crossing = end_crossing(before, after)
        if crossing is not None:
            found.append((max(abs(crossing.t - before.span[1]), abs(crossing.u - after.span[0])), i, j))
    gaps, ended, started = [], set[int](), set[int]()
    for gap, i, j in sorted(found):
        if gap <= WITHIN and i not in ended and j not in started:
            gaps.append(gap)
            ended.add(i)
            started.add(j)
    return gaps
