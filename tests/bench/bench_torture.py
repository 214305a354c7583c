"""What becomes of maps when something goes wrong: logs without odometry, with few beams, crowds, gaps; places unlike
the samples.

`make bench ARGS="torture -- [LOG …] [--tortures NAME …] [--places NAME …] [--scans N]"`. Errors are positions against
the truth of a log, or against its own untortured run where it has none; `astray` counts scans more than 0.3 m off
without having been said to be lost.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from bench.processes import run_module
from bench.recordings import recordings
from bench.torture import TORTURES, Recorded
from bench.torture_courts import COURTS
from bench.torture_rings import RINGS
from bench.torture_worlds import HALLS
from bspline_slam import se2
from bspline_slam.lab.evaluation import alignment
from bspline_slam.lab.simulation import simulate
from bspline_slam.logs import open_log
from bspline_slam.slam import run_slam
from splinescope.command_line.report import peak_memory_mb

PLACES = {**HALLS, **RINGS, **COURTS}
COLUMNS = ("scans", "keys", "splines", "loops", "lost", "unfit", "mean m", "most m", "astray", "CPU s", "MB")
IN_PLACES = ("as it is", "no odometry", "0.7 m and drift", "30 % missing", "30 % hidden", "laser upside down")
ASTRAY = 0.3
MOST = 2000


def recorded(source: str, most: int) -> Recorded:
    """The first scans of a log, or the drive through a place, with what they are held against."""
    if source in PLACES:
        drive = simulate(PLACES[source](), rng=np.random.default_rng(0))
        return Recorded.of(drive, drive.true_poses[drive.scan_records])
    log = open_log(source)
    if log.truth is not None:
        return Recorded.of(log, log.truth, most)
    plain = Recorded.of(log, np.zeros((len(log), 3)), most)
    return Recorded.of(log, run_slam(plain.log()).snapshot.poses, most)


def survived(plain: Recorded, torture: str) -> dict[str, Any]:
    """One row: the log after the torture, mapped with all defaults."""
    tortured = TORTURES[torture](plain, np.random.default_rng(0))
    log, start = tortured.log(), process_time()
    result = run_slam(log)
    spent, found, truth = process_time() - start, result.snapshot.poses[:, :2], tortured.truth[:, :2]
    error = np.linalg.norm(se2.transform(alignment(found, truth), found) - truth, axis=1)
    astray = error > ASTRAY
    astray[list(result.lost)] = False
    return {
        "scans": len(log),
        "keys": len(result.snapshot.key_scans),
        "splines": len(result.snapshot.map),
        "loops": sum(closure.accepted for closure in result.snapshot.loop_closures),
        "lost": len(result.lost),
        "unfit": len(result.unfit),
        "mean m": round(float(error.mean()), 3),
        "most m": round(float(error.max()), 2),
        "astray": int(np.count_nonzero(astray)),
        "CPU s": round(spent, 1),
        "MB": round(peak_memory_mb()),
    }


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print the table and return its rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="*", type=Path)
    parser.add_argument("--tortures", nargs="+", choices=TORTURES, metavar="NAME", help=", ".join(TORTURES))
    parser.add_argument("--places", nargs="*", choices=PLACES, metavar="NAME", help=", ".join(PLACES))
    parser.add_argument("--scans", type=int, default=MOST, help="the first so many of a log")
    parser.add_argument("--source", help="only this log or place, and print its rows as JSON")
    options = parser.parse_args(argv)
    if options.source is not None:
        plain = recorded(options.source, options.scans)
        rows = [{"log": Path(options.source).name, "torture": t} | survived(plain, t) for t in options.tortures]
        print(json.dumps(rows))
        return rows
    logs = options.logs or ([] if options.places else recordings())
    places = options.places if options.places is not None else [] if options.logs else list(PLACES)
    print(f"{'log':>24}{'torture':>20}" + "".join(f"{column:>8}" for column in COLUMNS))
    rows = []
    for source in (*map(str, logs), *places):
        for torture in options.tortures or (IN_PLACES if source in PLACES else TORTURES):
            arguments = ("--source", source, "--scans", options.scans, "--tortures", torture)
            row = json.loads(run_module("bench.bench_torture", *arguments))[0]
            rows.append(row)
            print(f"{row['log']:>24}{torture:>20}" + "".join(f"{row[c]!s:>8}" for c in COLUMNS), flush=True)
    return rows


if __name__ == "__main__":
    main(sys.argv[1:])
