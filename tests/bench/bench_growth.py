"""How time and memory grow with the log: streets as long as the Intel log, three and ten times that.

`make bench ARGS="growth -- --blocks 2 --times 1 3"`: a smaller base is quicker. Every length is driven and mapped in
processes of its own, from a file, as a real log would be.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from bench.processes import run_module
from bench.street import INTEL_BLOCKS
from bspline_slam import se2
from bspline_slam.estimates import marginals
from bspline_slam.lab.evaluation import alignment
from bspline_slam.logs import open_log
from bspline_slam.slam import Slam
from bspline_slam.slam_config import SlamConfig
from splinescope.command_line.report import peak_memory_mb

COLUMNS = (
    "times", "scans", "keys", "splines", "front s", "ms/scan", "95 % ms", "finish s", "ms/key", "covar s", "MB",
    "error mm",
)  # fmt: skip


def mapped(path: Path) -> dict[str, Any]:
    """Processor time of each stage over one log, in this process, and the most memory it held."""
    log = open_log(path)
    pipeline, spent, now = Slam(log, SlamConfig()), [], process_time()
    for _ in pipeline.steps():
        before, now = now, process_time()
        spent.append(now - before)
    start = process_time()
    snapshot = pipeline.finish()
    finished = process_time()
    marginals(snapshot, splines=[spline.id for spline in snapshot.map])
    done = process_time()
    assert log.truth is not None
    found, truth = snapshot.poses[:, :2], log.truth[:, :2]
    error = np.linalg.norm(se2.transform(alignment(found, truth), found) - truth, axis=1)
    return {
        "scans": len(log),
        "keys": len(snapshot.key_scans),
        "splines": len(snapshot.map),
        "front s": round(sum(spent), 1),
        "ms/scan": round(1e3 * sum(spent) / len(log), 2),
        "95 % ms": round(1e3 * float(np.percentile(spent, 95)), 1),
        "finish s": round(finished - start, 1),
        "ms/key": round(1e3 * (finished - start) / len(snapshot.key_scans), 2),
        "covar s": round(done - finished, 1),
        "MB": round(peak_memory_mb()),
        "error mm": round(1e3 * float(error.mean()), 1),
    }


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print the table and return its rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=INTEL_BLOCKS, help="length of the shortest street")
    parser.add_argument("--times", type=int, nargs="+", default=[1, 3, 10])
    parser.add_argument("--map", type=Path, metavar="LOG", help="only map this log, and print its row as JSON")
    options = parser.parse_args(argv)
    if options.map is not None:
        row = mapped(options.map)
        print(json.dumps(row))
        return [row]
    print(f"processor time; once is {options.blocks} blocks")
    print("".join(f"{column:>10}" for column in COLUMNS))
    rows = []
    with TemporaryDirectory() as folder:
        for times in options.times:
            log = Path(folder) / f"street{times}.log.gz"
            run_module("bench.street", options.blocks * times, log)
            rows.append({"times": times} | json.loads(run_module("bench.bench_growth", "--map", log)))
            print("".join(f"{rows[-1][column]!s:>10}" for column in COLUMNS), flush=True)
    growth = rows[-1]["ms/scan"] / rows[0]["ms/scan"]
    print(f"a scan of the longest takes {growth:.2f} times as long as one of the shortest")
    return rows


if __name__ == "__main__":
    main(sys.argv[1:])
