"""Whole logs from first byte to written map: time, memory, size of the map, and error where it can be known."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from bench.recordings import recordings, recordings_folder

COLUMNS = ("log", "scans", "keys", "splines", "points", "chi2/dof", "seconds", "MB", "error m", "error °", "scored")


def splinescope(*arguments: str | Path) -> str:
    """What a command prints, from a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "splinescope", *map(str, arguments)], capture_output=True, text=True, check=True
    )
    return done.stdout


def mapped(log: Path, out: Path) -> dict[str, Any]:
    """One log, run and evaluated."""
    start = perf_counter()
    splinescope("run", log, "--out", out)
    wall = perf_counter() - start
    report = json.loads((out / "report.json").read_text())
    counts = report["counts"]
    row: dict[str, Any] = {
        "log": log.name,
        "scans": counts["scans"],
        "keys": counts["key_scans"],
        "splines": counts["splines"],
        "points": counts["control_points"],
        "chi2/dof": round(report["chi2_per_dof"], 2),
        "seconds": round(wall, 1),
        "MB": round(report["peak_memory_mb"]),
    }
    return row | errors(log, out)


def errors(log: Path, out: Path) -> dict[str, Any]:
    """Mean error against hand-checked relations, else against the truth beside the log; nothing without either."""
    relations = recordings_folder() / f"{log.name.split('-')[0]}-clean.relations"
    truth = log.with_name(log.name.split(".")[0] + ".truth.tum")
    if relations.exists():
        found = json.loads(splinescope("evaluate", out, "--relations", relations, "--json"))["relations"]
        return {
            "error m": round(found["translation_m"]["mean"], 4),
            "error °": round(found["rotation_deg"]["mean"], 3),
            "scored": found["scored"],
        }
    if truth.exists():
        found = json.loads(splinescope("evaluate", out, "--reference", truth, "--json"))["reference"]
        return {"error m": round(found["ate_m"]["mean"], 4)}
    return {}


def main(argv: list[str]) -> list[dict[str, Any]]:
    """Print the table and return its rows."""
    rows = []
    print("".join(f"{column:>16}" if k == 0 else f"{column:>10}" for k, column in enumerate(COLUMNS)))
    for log in recordings():
        with TemporaryDirectory() as folder:
            row = mapped(log, Path(folder))
        rows.append(row)
        cells = [str(row.get(column, "–")) for column in COLUMNS]
        print("".join(f"{cell[:16]:>16}" if k == 0 else f"{cell:>10}" for k, cell in enumerate(cells)), flush=True)
    return rows


if __name__ == "__main__":
    main(sys.argv[1:])
