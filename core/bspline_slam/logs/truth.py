"""True poses beside a log: `office.truth.tum` next to `office.log.gz`, `office.mcap` or the folder `office`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam.scan import interpolate_poses

_SUFFIXES = (".gz", ".log", ".clf", ".txt", ".bag", ".mcap", ".db3")
_SLACK = 0.1


def companion(log: Path) -> Path | None:
    """The truth file beside a log, if there is one."""
    stem = log.name
    while stem.endswith(_SUFFIXES):
        stem = stem.rpartition(".")[0]
    candidates = (log.parent / f"{name}.truth.tum" for name in dict.fromkeys((stem, log.name)))
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def truth_at(file: Path, stamps: Float[np.ndarray, "scans"]) -> tuple[Float[np.ndarray, "scans 3"] | None, list[str]]:
    """The true pose at each stamp, from lines `t x y z qx qy qz qw`; None, and why, where the file does not serve."""
    left_out = f"The true poses in {file.name} are left out"
    try:
        lines = [line.split() for line in file.read_text().splitlines() if line.strip() and not line.startswith("#")]
        rows = np.array(lines, dtype=float)
    except (ValueError, OSError):
        rows = np.zeros((0, 0))
    if rows.ndim != 2 or rows.shape[1] != 8 or not np.isfinite(rows).all():
        return None, [f"{left_out}: each line needs eight numbers (t x y z qx qy qz qw)."]
    _, first = np.unique(rows[:, 0], return_index=True)
    rows = rows[first]
    outside = np.mean((stamps < rows[0, 0] - _SLACK) | (stamps > rows[-1, 0] + _SLACK))
    if outside > 0.5:
        return None, [f"{left_out}: their times are not those of the scans."]
    notes = [f"{file.name} does not reach {outside:.0%} of the scans: its pose is held beyond its ends."]
    x, y, z, w = rows[:, 4:].T
    heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    poses = np.column_stack([rows[:, 1:3], heading])
    truth = np.array([interpolate_poses(rows[:, 0], poses, float(stamp)) for stamp in stamps])
    return truth, notes if outside > 0 else []
