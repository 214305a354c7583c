"""The paper's experiments done again, one module per figure; each writes figure and data and gives table rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from bspline_slam.errors import ConfigError
from bspline_slam.lab.reproduction import clamped_cubic, invariance, relations, three_splines, uncertainty
from bspline_slam.lab.reproduction.reproduced import Reproduced

EXPERIMENTS: tuple[tuple[range, Callable[[Path], Reproduced]], ...] = (
    (range(1, 2), clamped_cubic.reproduce),
    (range(2, 4), invariance.reproduce),
    (range(4, 5), uncertainty.reproduce),
    (range(5, 8), relations.reproduce),
    (range(8, 9), three_splines.reproduce),
)
"""Numbers of the paper's figures, and what does them again."""


def reproduce(out: Path, figure: int | None = None) -> Sequence[Reproduced]:
    """Do one experiment again, or all; raises ConfigError for a figure that none belongs to."""
    chosen = [run for numbers, run in EXPERIMENTS if figure is None or figure in numbers]
    if not chosen:
        known = ", ".join(str(number) for numbers, _ in EXPERIMENTS for number in numbers)
        raise ConfigError(f"there is no figure {figure} to reproduce: choose one of {known}")
    return [run(out) for run in chosen]
