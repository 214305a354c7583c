"""Twins of whole logs: errors against the truth under several seeds. `make bench ARGS="twin -- --help"`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.processes import run_module
from bench.recordings import SAMPLES, recordings_folder
from splinescope.command_line import twin_table as table
from splinescope.command_line.twin import run_trials
from splinescope.command_line.twin_source import chosen_stretch, read_twin

OFFICE, INTEL = SAMPLES / "office.log.gz", "intel-lab.log.gz"


def trials_on(log: Path, seeds: range, scans: str | None) -> dict[str, Any]:
    """Run the pipeline on a log, then on its twins; prints the table and returns its figures."""
    with TemporaryDirectory() as folder:
        run_module("splinescope", "run", log, "--out", folder)
        twin = chosen_stretch(read_twin(Path(folder), log), scans)
    print(f"-- {twin.name}", flush=True)
    trials = run_trials(twin, seeds, lambda stage, share: None, lambda: False, lambda line: print(line, flush=True))
    print(table.closing(trials))
    return {"log": log.name} | table.figures(seeds, trials)


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print a table for each log and return the rows of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "logs", nargs="*", type=Path, help="logs to make twins of (default: office, and Intel if there)"
    )
    parser.add_argument("--seeds", type=int, help="how many (default: 5 for the office, 2 for others)")
    parser.add_argument("--scans", metavar="FIRST:LAST", help="only a stretch of each log")
    options = parser.parse_args(argv)
    logs = options.logs or [log for log in (OFFICE, recordings_folder() / INTEL) if log.exists()]
    return [trials_on(log, range(options.seeds or (5 if log == OFFICE else 2)), options.scans) for log in logs]


if __name__ == "__main__":
    main(sys.argv[1:])
