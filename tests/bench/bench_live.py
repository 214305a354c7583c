"""Scan by scan, as a robot would bring them: how long each takes, alone and with the map adjusted beside it.

`make bench ARGS="live -- [LOG] [--scans N]"`, by default the largest log at hand. Times are from asking for a
scan to having its step: reading, matching, loop closing, mapping.
"""

from __future__ import annotations

import argparse
import sys
from contextlib import closing
from pathlib import Path
from time import perf_counter, process_time, thread_time
from typing import Any

import numpy as np

from bench.recordings import largest_recording
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Slam
from bspline_slam.slam_config import SlamConfig
from splinescope.computing.live_map import LiveMap
from splinescope.computing.messages import Message
from splinescope.computing.reporter import Reporter

PERCENTILES = (50, 95, 99, 100)


def unheard(message: Message) -> None:
    """Where no page listens."""


def driven(log: ScanLog, scans: int, *, adjusting: bool) -> dict[str, Any]:
    """Milliseconds per scan, on the clock and on the processor, and processor seconds of everything."""
    config = SlamConfig()
    pipeline, reporter, spent = Slam(log, config), Reporter(1, unheard), []
    steps, start = pipeline.steps(), process_time()
    with closing(LiveMap(config)) as live:
        for _ in range(min(scans, len(log))):
            wall, processor = perf_counter(), thread_time()
            step = next(steps)
            spent.append((perf_counter() - wall, thread_time() - processor))
            if adjusting:
                reporter.step(live.carried(step))
                reporter.map(lambda: live.shown(pipeline.snapshot()))
    return {"processor_s": round(process_time() - start, 1)} | percentiles(1e3 * np.array(spent))


def percentiles(spent: np.ndarray) -> dict[str, float]:
    """Of the clock's milliseconds and of the processor's."""
    found = np.percentile(spent, PERCENTILES, axis=0)
    return {
        f"{what} {percent} %": round(float(value), 1)
        for column, what in enumerate(("ms", "processor ms"))
        for percent, value in zip(PERCENTILES, found[:, column], strict=True)
    }


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print the table and return its rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", nargs="?", type=Path, default=largest_recording())
    parser.add_argument("--scans", type=int, default=sys.maxsize)
    options = parser.parse_args(argv)
    log = open_log(options.log)
    driven(log, 200, adjusting=True)  # compiled, or read from the cache
    rows = []
    for what, adjusting in (("front end alone", False), ("map adjusted beside it", True)):
        row = {"what": what, "log": log.name} | driven(log, options.scans, adjusting=adjusting)
        print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
        rows.append(row)
    return rows


if __name__ == "__main__":
    main(sys.argv[1:])
