"""Whole logs from first byte to written map: time, memory, size and fit of the map, and error where it can be known."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from bench.recordings import recordings, recordings_folder

COLUMNS = (
    "log", "scans", "keys", "splines", "points", "chi2/dof", "seconds", "MB", "held mm", "in 3 cm", "error m",
    "error °", "scored",
)  # fmt: skip


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
    return row | figures(log, out)


def figures(log: Path, out: Path) -> dict[str, Any]:
    """How well the map fits beams that it was not fitted to, and the mean error against hand-checked relations, else
    against the truth beside the log where there is either."""
    relations = recordings_folder() / f"{log.name.split('-')[0]}-clean.relations"
    truth = log.with_name(log.name.split(".")[0] + ".truth.tum")
    against = ["--relations", relations] if relations.exists() else ["--reference", truth] if truth.exists() else []
    found = json.loads(splinescope("evaluate", out, "--log", log, *against, "--json"))
    row: dict[str, Any] = {
        "held mm": round(1e3 * found["held_out"]["rms_within_5cm_m"], 2),
        "in 3 cm": round(found["held_out"]["share_within_3cm"], 3),
    }
    if "relations" in found:
        errors = found["relations"]
        row["error m"] = round(errors["translation_m"]["mean"], 4)
        row["error °"] = round(errors["rotation_deg"]["mean"], 3)
        row["scored"] = errors["scored"]
    elif "reference" in found:
        row["error m"] = round(found["reference"]["ate_m"]["mean"], 4)
    return row


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
