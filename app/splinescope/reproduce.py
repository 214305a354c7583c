"""The table "paper / ours" as text for a terminal and for the README."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bspline_slam.lab.reproduction import reproduce
from bspline_slam.lab.reproduction.reproduced import Reproduced


def reproduce_and_describe(out: Path, figure: int | None) -> str:
    """Write the figures and data; the table and the place of the files."""
    results = reproduce(out, figure)
    written = sum(len(result.files) for result in results)
    return f"{table_text(results)}\n\n{written} files in {out}"


def table_text(results: Sequence[Reproduced]) -> str:
    """A Markdown table, one row per quantity."""
    lines = ["| figure | quantity | paper | ours |", "|---|---|---|---|"]
    lines += [f"| {row.figure} | {row.quantity} | {row.paper} | {row.ours} |" for one in results for row in one.rows]
    return "\n".join(lines)
