"""Whole logs from first byte to written map: time by stage, memory, size and fit of the map, and error where known.

`make bench ARGS="logs -- [LOG …]"`, by default the office sample and all recordings at hand.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from bench.processes import run_module
from bench.recordings import recordings

COLUMNS = (
    "log", "scans", "keys", "splines", "points", "χ²/dof", "wall s", "CPU s", "scans s", "adjust s", "covar s", "MB",
    "held mm", "in 3 cm", "clean m", "clean °", "worst m", "all m", "all °", "truth m",
)  # fmt: skip
WIDTH = 9


def mapped(log: Path, out: Path) -> dict[str, Any]:
    """One log, run and evaluated."""
    start = perf_counter()
    run_module("splinescope", "run", log, "--out", out)
    wall = perf_counter() - start
    report = json.loads((out / "report.json").read_text())
    counts, seconds = report["counts"], report["seconds"]
    row: dict[str, Any] = {
        "log": log.name,
        "scans": counts["scans"],
        "keys": counts["key_scans"],
        "splines": counts["splines"],
        "points": counts["control_points"],
        "χ²/dof": round(report["chi2_per_dof"], 2),
        "wall s": round(wall, 1),
        "CPU s": report["processor_seconds"],
        "scans s": round(seconds["scans"], 1),
        "adjust s": round(seconds["adjustment"], 1),
        "covar s": round(seconds["covariances"], 1),
        "MB": round(report["peak_memory_mb"]),
    }
    return row | figures(log, out)


def figures(log: Path, out: Path) -> dict[str, Any]:
    """How well the map fits beams that it was not fitted to, and the mean errors against hand-checked relations, or
    against the truth, where there are any beside the log."""
    found = evaluated(out, "--log", log)
    row: dict[str, Any] = {
        "held mm": round(1e3 * found["held_out"]["rms_within_5cm_m"], 2),
        "in 3 cm": round(found["held_out"]["share_within_3cm"], 3),
    }
    for name, file in (("clean", "-clean.relations"), ("all", ".relations")):
        relations = log.with_name(log.name.split("-")[0] + file)
        if relations.exists():
            errors = evaluated(out, "--relations", relations)["relations"]
            row[f"{name} m"] = round(errors["translation_m"]["mean"], 4)
            row[f"{name} °"] = round(errors["rotation_deg"]["mean"], 3)
            if name == "clean":
                row["worst m"] = round(errors["translation_m"]["maximum"], 3)
    truth = log.with_name(log.name.split(".")[0] + ".truth.tum")
    if truth.exists():
        row["truth m"] = round(evaluated(out, "--reference", truth)["reference"]["ate_m"]["mean"], 4)
    return row


def evaluated(out: Path, *options: str | Path) -> dict[str, Any]:
    """What `evaluate` finds of a run."""
    return json.loads(run_module("splinescope", "evaluate", out, *options, "--json"))


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print the table and return its rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="*", type=Path, default=recordings())
    rows = []
    print("".join(f"{column:>{width(column)}}" for column in COLUMNS))
    for log in parser.parse_args(argv).logs:
        with TemporaryDirectory() as folder:
            row = mapped(log, Path(folder))
        rows.append(row)
        print("".join(f"{row.get(column, '–')!s:>{width(column)}}" for column in COLUMNS), flush=True)
    return rows


def width(column: str) -> int:
    """Characters of a column."""
    return 22 if column == "log" else WIDTH


if __name__ == "__main__":
    main(sys.argv[1:])
