"""Whether the compiled inner loops are at hand, or the first call of each will compile it."""

from __future__ import annotations

from pathlib import Path

from bspline_slam.kernels import matching


def is_filled() -> bool:
    """Whether an earlier run left its compiled loops in numba's cache: beside the sources, or in NUMBA_CACHE_DIR."""
    folder = matching.refine.stats.cache_path
    return folder is not None and any(Path(folder).glob("matching.refine-*.nbi"))
