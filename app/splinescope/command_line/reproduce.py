"""The table "paper / ours" as text for a terminal and for the README."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from bspline_slam.backends.protocol import Cancelling
from bspline_slam.lab.reproduction import RECORDED, reproduce
from bspline_slam.lab.reproduction.reproduced import Reproduced
from bspline_slam.logs import open_log
from splinescope.command_line.run import in_words

Progress = Callable[[str, float], None]
LEFT_OUT = f"Figure {RECORDED} was left out: it is made from the Intel log, given with --intel PATH."


def reproduce_and_describe(
    out: Path, figure: int | None, log_path: Path | None, progress: Progress, cancelled: Cancelling
) -> str:
    """Write the figures and data; the table and the place of the files."""
    log = None
    if log_path is not None and figure in (None, RECORDED):
        log = open_log(log_path, progress=lambda share: progress("Reading the log", share))
    results = reproduce(out, figure, log, in_words(progress), cancelled)
    written = sum(len(result.files) for result in results)
    notes = [f"{written} files in {out}", *([LEFT_OUT] if log is None and figure is None else [])]
    return "\n\n".join([table_text(results), *notes])


def table_text(results: Sequence[Reproduced]) -> str:
    """A Markdown table, one row per quantity."""
    lines = ["| figure | quantity | paper | ours |", "|---|---|---|---|"]
    lines += [f"| {row.figure} | {row.quantity} | {row.paper} | {row.ours} |" for one in results for row in one.rows]
    return "\n".join(lines)
