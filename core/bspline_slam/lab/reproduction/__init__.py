"""The paper's experiments done again, one module per figure; each writes figure and data and gives table rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from bspline_slam.backends.protocol import Cancelling, never
from bspline_slam.errors import ConfigError
from bspline_slam.lab.reproduction import clamped_cubic, invariance, recorded, relations, three_splines, uncertainty
from bspline_slam.lab.reproduction.reproduced import Reproduced
from bspline_slam.progress import StageProgress, quiet
from bspline_slam.scan import ScanLog

EXPERIMENTS: tuple[tuple[range, Callable[[Path], Reproduced]], ...] = (
    (range(1, 2), clamped_cubic.reproduce),
    (range(2, 4), invariance.reproduce),
    (range(4, 5), uncertainty.reproduce),
    (range(5, 8), relations.reproduce),
    (range(8, 9), three_splines.reproduce),
)
"""Numbers of the paper's figures, and what does them again."""
RECORDED = 9
"""The figure that is made from a recorded log."""


def reproduce(
    out: Path,
    figure: int | None = None,
    log: ScanLog | None = None,
    progress: StageProgress = quiet,
    cancelled: Cancelling = never,
) -> Sequence[Reproduced]:
    """Do one experiment again, or all; figure 9 only with a log, and it alone takes long enough to show progress.

    Raises ConfigError for a figure that no experiment belongs to, or whose log is not given; Cancelled.
    """
    known = [number for numbers, _ in EXPERIMENTS for number in numbers] + [RECORDED]
    if figure is not None and figure not in known:
        raise ConfigError(f"there is no figure {figure} to reproduce: choose one of {', '.join(map(str, known))}")
    if figure == RECORDED and log is None:
        raise ConfigError(f"figure {RECORDED} is made from a recorded log: give the Intel log with --intel PATH")
    results = [run(out) for numbers, run in EXPERIMENTS if figure is None or figure in numbers]
    if log is not None and figure in (None, RECORDED):
        results.append(recorded.reproduce(out, log, progress, cancelled))
    return results
