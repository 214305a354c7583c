"""Progress of the pipeline, for whoever watches."""

from __future__ import annotations

from collections.abc import Callable

from bspline_slam.backends.protocol import IterationRecord

StageProgress = Callable[[str, float, IterationRecord | None], None]
"""Told of the stage, the share of it that is done (0 … 1), and the iteration of a solver where it is one."""


def quiet(stage: str, fraction: float, record: IterationRecord | None) -> None:
    """Progress that nobody watches."""
