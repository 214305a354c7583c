"""The map of a running job as the page shows it: adjusted beside the front end, in a thread of its own."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.errors import Cancelled, SplineSlamError
from bspline_slam.incremental import Adjusted, adjust_so_far
from bspline_slam.slam import SlamConfig, SlamStep, Snapshot

logger = logging.getLogger(__name__)

REST = 2.0
"""An adjustment that took s seconds of processor time is followed by REST · s seconds without one."""
LEAST_KEY_SCANS = 10

Adjust = Callable[[Snapshot, SlamConfig, Callable[[], bool]], Adjusted]


class LiveMap:
    """Takes a snapshot of the front end whenever the page is due one, and adjusts it while the front end goes on.

    Nothing comes back to the front end: what a run gives in the end does not hang on how fast this is.
    """

    def __init__(
        self, config: SlamConfig, adjust: Adjust = adjust_so_far, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._config, self._adjust, self._clock = config, adjust, clock
        self._pool = ThreadPoolExecutor(1, "live map")
        self._closed = threading.Event()
        self._running: Future[tuple[Adjusted | None, float]] | None = None
        self._latest: Adjusted | None = None
        self._rested = clock()
        self._motion = se2.IDENTITY

    def shown(self, front: Snapshot) -> tuple[Snapshot, int]:
        """The front end's snapshot as far as it is adjusted, and up to how many scans that is; the next adjustment
        begins with it where that is due."""
        self._take()
        self._begin(front)
        latest = self._latest
        if latest is None or not latest.fits(front):
            self._motion = se2.IDENTITY
            return front, 0
        live = latest.applied(front)
        self._motion = se2.compose(live.poses[-1], se2.inverse(front.poses[-1]))
        return live, int(latest.key_scans[-1]) + 1

    def carried(self, step: SlamStep) -> SlamStep:
        """A step beside the map that was last shown."""
        if not np.any(self._motion):
            return step
        at = se2.compose(self._motion, np.stack([step.predicted, step.pose]))
        return replace(step, predicted=at[0], pose=at[1])

    def close(self) -> None:
        """Give up what is being adjusted, and wait until it is."""
        self._closed.set()
        self._pool.shutdown()

    def _take(self) -> None:
        if self._running is not None and self._running.done():
            adjusted, spent = self._running.result()
            self._latest = adjusted or self._latest
            self._rested = self._clock() + REST * spent
            self._running = None

    def _begin(self, front: Snapshot) -> None:
        known = 0 if self._latest is None else len(self._latest.key_scans)
        fresh = len(front.key_scans) >= LEAST_KEY_SCANS and len(front.key_scans) > known
        if fresh and self._running is None and self._clock() >= self._rested:
            self._running = self._pool.submit(self._adjusted, front)

    def _adjusted(self, front: Snapshot) -> tuple[Adjusted | None, float]:
        """The adjustment, None where it came to nothing, and its processor time (s)."""
        start = time.thread_time()
        adjusted = None
        try:
            adjusted = self._adjust(front, self._config, self._closed.is_set)
        except Cancelled:
            pass
        except SplineSlamError as error:
            logger.info("the map is not adjusted up to scan %d: %s", len(front.poses) - 1, error)
        return adjusted, time.thread_time() - start
