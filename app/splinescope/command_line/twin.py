"""The command `twin`: a finished run simulated again under many seeds, each log put through the whole pipeline."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.errors import ConfigError
from bspline_slam.lab.twin import Twin
from bspline_slam.lab.twin_trial import TwinErrors, run_trial
from bspline_slam.slam import SlamConfig
from splinescope.activity import STAGES
from splinescope.command_line.twin_table import HEADERS, cells, line

Progress = Callable[[str, float], None]
Cancelling = Callable[[], bool]


def run_trials(
    twin: Twin, seeds: Sequence[int], progress: Progress, cancelled: Cancelling, done: Callable[[str], None]
) -> list[TwinErrors]:
    """One trial per seed, each with the default configuration; `done` gets its line of the table. Raises Cancelled."""
    if not seeds:
        raise ConfigError("at least one seed is needed")
    trials: list[TwinErrors] = []
    done(line(HEADERS))
    for number, seed in enumerate(seeds, start=1):
        words = f"seed {seed} ({number} of {len(seeds)})"

        def watch(stage: str, share: float, _: IterationRecord | None, words: str = words) -> None:
            if stage in STAGES:
                progress(f"{STAGES[stage]}, {words}", share)

        trials.append(run_trial(twin, np.random.default_rng(seed), SlamConfig(), watch, cancelled))
        done(line(cells(str(seed), [trials[-1]])))
    return trials
