"""Compiling before the work begins, where no earlier run did."""

from __future__ import annotations

from collections.abc import Callable

from bspline_slam.kernels import cache
from bspline_slam.logs import open_log
from bspline_slam.slam import run_slam
from splinescope.paths import find_log

COMPILING = "Compiling for this machine (the first run only, about a minute)"
SMALLEST = "three_splines"
"""The sample that passes through every stage soonest."""
SHARES = {"scans": (0.0, 0.5), "pose graph": (0.5, 0.0), "adjustment": (0.5, 0.5)}
"""Where each stage of its run begins, as a share of the whole, and how much of that it takes."""


def prepare(progress: Callable[[str, float], None], cancelled: Callable[[], bool]) -> None:
    """Compile the inner loops and say so, unless they are in numba's cache already. Raises Cancelled."""
    if cache.is_filled():
        return
    progress(COMPILING, 0.0)

    def tell(stage: str, share: float, _: object) -> None:
        if stage in SHARES:
            begins, takes = SHARES[stage]
            progress(COMPILING, begins + takes * min(share, 0.99))

    run_slam(open_log(find_log(SMALLEST)), progress=tell, cancelled=cancelled)
