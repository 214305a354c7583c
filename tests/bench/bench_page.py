"""The server's side of the page on the largest log at hand: index pass, a step, a step while solving."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, perf_counter, sleep
from typing import Any

import numpy as np

from bench.recordings import largest_recording
from bspline_slam.logs import open_log
from splinescope import commands as ask
from splinescope.browser.page import open_page
from splinescope.viewer import Viewer

FRAME = 1 / 30


class Bench:
    """A viewer without a browser whose loop is turned by hand."""

    def __init__(self, folder: Path) -> None:
        self.viewer = Viewer(open_page("127.0.0.1", 0, title="bench"), folder / "preferences.json")

    def turn(self) -> None:
        """One round of the viewer's loop."""
        for item in self.viewer._arrivals():
            self.viewer._take(item.item)
        self.viewer.session.tick()
        self.viewer._presenter.show()

    def until(self, done: Callable[[], bool], limit: float = 900.0) -> None:
        end = monotonic() + limit
        while not done():
            if monotonic() > end:
                raise TimeoutError("the estimator did not finish")
            self.turn()

    def steps(self, count: int, keep_on: Callable[[], bool]) -> np.ndarray:
        """Milliseconds of `count` jumps to scans far apart, from command to drawn, at 30 a second."""
        session, rng, spent = self.viewer.session, np.random.default_rng(0), []
        assert session.log is not None
        while len(spent) < count and keep_on():
            self.turn()
            sleep(FRAME)
            start = perf_counter()
            self.viewer._take(ask.Seek(int(rng.integers(len(session.log)))))
            self.viewer._presenter.show()
            spent.append(1e3 * (perf_counter() - start))
        return np.array(spent)


def milliseconds(what: str, spent: np.ndarray) -> dict[str, Any]:
    row = {
        "what": what,
        "count": len(spent),
        "median ms": round(float(np.median(spent)), 1),
        "95 % ms": round(float(np.percentile(spent, 95)), 1),
        "worst ms": round(float(spent.max()), 1),
    }
    print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
    return row


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print and return the rows."""
    path = largest_recording()
    print(path.name)
    passes = []
    for _ in range(3):
        start = perf_counter()
        open_log(path)
        passes.append(1e3 * (perf_counter() - start))
    rows = [milliseconds("index pass", np.array(passes))]
    with TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        session = bench.viewer.session
        try:
            bench.viewer.post(ask.OpenLog(path))
            bench.until(lambda: session.log is not None)
            bench.until(lambda: not session.busy and session.map_view is not None)
            rows.append(milliseconds("step", bench.steps(300, lambda: True)))
            bench.viewer.post(ask.Optimise())
            bench.until(lambda: session.busy)
            rows.append(milliseconds("step while solving", bench.steps(300, lambda: session.busy)))
        finally:
            bench.viewer.close()
    return rows


if __name__ == "__main__":
    main(sys.argv[1:])
