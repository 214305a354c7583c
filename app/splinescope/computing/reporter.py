"""What a running job says about itself, no more often than a page can show."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.errors import Cancelled, SplineSlamError
from bspline_slam.slam import SlamStep, Snapshot
from splinescope.computing.messages import (
    Failed,
    Iterated,
    MapChanged,
    Message,
    Progress,
    StepsDone,
    Stopped,
    for_looking_at,
)

logger = logging.getLogger(__name__)

RECORD_INTERVAL = 0.2
STEP_INTERVAL = 0.1
PROGRESS_INTERVAL = 0.25
MAP_INTERVAL = 0.5
MAP_SHARE = 20.0
"""A map that took s seconds to make is followed by at least MAP_SHARE · s seconds of work."""


@contextmanager
def failures_told(job: int, send: Callable[[Message], None], who: str) -> Iterator[None]:
    """Whatever goes wrong in a job inside is sent as a sentence about `who` does it."""
    try:
        yield
    except Cancelled:
        send(Stopped(job))
    except SplineSlamError as error:
        send(Failed(job, str(error)))
    except Exception as error:
        logger.exception("job %d of the %s failed", job, who)
        send(Failed(job, f"The {who} failed unexpectedly ({type(error).__name__}: {error})."))


class Reporter:
    """Sends the messages of job number `job`, those that come in numbers gathered and thinned by the clock."""

    def __init__(self, job: int, send: Callable[[Message], None], clock: Callable[[], float] = time.monotonic) -> None:
        self.job = job
        self.send = send
        self._clock = clock
        self._stage = ""
        self._stage_start = self._last_progress = self._last_record = self._last_steps = clock()
        self._next_map = clock()
        self._steps: list[SlamStep] = []

    def stage(self, name: str) -> None:
        """A stage begins that cannot say how far it is."""
        self._stage, self._stage_start = name, self._clock()
        self.send(Progress(self.job, name))

    def progress(self, stage: str, fraction: float, record: IterationRecord | None = None) -> None:
        """A stage is at `fraction`; `record` is the solver's iteration if it made one."""
        now = self._clock()
        if stage != self._stage:
            self._stage, self._stage_start, self._last_progress = stage, now, -float("inf")
        if record is not None and (record.index == 0 or now - self._last_record >= RECORD_INTERVAL):
            self._last_record = now
            self.send(Iterated(self.job, record))
        if now - self._last_progress >= PROGRESS_INTERVAL:
            self._last_progress = now
            left = seconds_left(now - self._stage_start, fraction)
            self.send(Progress(self.job, stage, min(max(fraction, 0.0), 1.0), left))

    def step(self, step: SlamStep) -> None:
        """One more scan is processed."""
        self._steps.append(step)
        if self._clock() - self._last_steps >= STEP_INTERVAL:
            self.flush()

    def flush(self) -> None:
        """Send the steps that were held back."""
        if self._steps:
            self.send(StepsDone(self.job, tuple(self._steps)))
        self._steps, self._last_steps = [], self._clock()

    def map(self, make: Callable[[], tuple[Snapshot, int]]) -> None:
        """Send the map if it is time for it; `make` is called only then, and gives up to how many scans it is adjusted
        besides."""
        start = self._clock()
        if start < self._next_map:
            return
        self.flush()
        snapshot, adjusted = make()
        self.send(MapChanged(self.job, for_looking_at(snapshot), adjusted))
        end = self._clock()
        self._next_map = end + max(MAP_INTERVAL, MAP_SHARE * (end - start))


def seconds_left(elapsed: float, fraction: float) -> float | None:
    """Time a stage still takes if it goes on as it went; None while that is a guess."""
    if elapsed < 1.0 or fraction < 0.02:
        return None
    return elapsed * (1.0 - min(fraction, 1.0)) / fraction
