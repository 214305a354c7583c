"""The command `consistency`: experiments run many times over all cores, and what comes of them as table and files."""

from __future__ import annotations

import json
import math
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bspline_slam.backends import BACK_ENDS
from bspline_slam.errors import Cancelled, ConfigError, GeometryError, SolverError
from bspline_slam.export.consistency_svg import consistency_to_svg
from bspline_slam.lab.consistency import ASSOCIATIONS, Experiment, RunErrors, run_once
from bspline_slam.lab.consistency_table import Figure, Row, summarise
from bspline_slam.lab.world_file import open_world
from bspline_slam.observation import MODELS

POLL = 0.2
"""How often (s) cancelling is looked for."""

Progress = Callable[[str, float], None]
Cancelling = Callable[[], bool]


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """What came of one run: its errors, or the sentence with which the estimator gave up."""

    number: int
    errors: RunErrors | None
    problem: str = ""


def experiments(
    worlds: Sequence[str], models: Sequence[str], back_ends: Sequence[str], associations: Sequence[str]
) -> list[Experiment]:
    """All combinations; raises ConfigError for a name that does not exist before anything runs."""
    for kind, names, known in (
        ("model", models, MODELS),
        ("back end", back_ends, BACK_ENDS),
        ("association", associations, ASSOCIATIONS),
    ):
        if unknown := [name for name in names if name not in known]:
            raise ConfigError(f'there is no {kind} "{unknown[0]}": choose among {", ".join(known)}')
    for world in worlds:
        open_world(world)
    return [Experiment(*names) for names in product(worlds, models, back_ends, associations)]


def run_experiments(
    wanted: Sequence[Experiment], runs: int, seed: int, progress: Progress, cancelled: Cancelling
) -> list[Row]:
    """Each experiment `runs` times, in processes of their own; run k has the same log in all that share a world.

    Raises Cancelled.
    """
    if runs < 1:
        raise ConfigError(f"at least one run is needed, got {runs}")
    outcomes: dict[int, list[Outcome]] = {number: [] for number in range(len(wanted))}
    with workers(min(len(wanted) * runs, os.cpu_count() or 1)) as (pool, stop):
        with interrupts_ignored():
            tasks = {
                pool.submit(attempt, experiment, seed, run): number
                for run in range(runs)
                for number, experiment in enumerate(wanted)
            }
        progress("Simulating and estimating", 0.0)
        try:
            for task in finished(tasks, cancelled):
                outcomes[tasks[task]].append(task.result())
                progress("Simulating and estimating", sum(map(len, outcomes.values())) / len(tasks))
        except BrokenProcessPool:
            raise SolverError("a process of the study was killed, perhaps for want of memory") from None
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
    return [_row(experiment, outcomes[number]) for number, experiment in enumerate(wanted)]


def _row(experiment: Experiment, outcomes: list[Outcome]) -> Row:
    ordered = sorted(outcomes, key=lambda outcome: outcome.number)
    errors = [outcome.errors for outcome in ordered if outcome.errors is not None]
    return summarise(experiment, errors, [outcome.problem for outcome in ordered if outcome.errors is None])


@contextmanager
def workers(count: int) -> Iterator[tuple[ProcessPoolExecutor, Event]]:
    """Processes to be, and the event that tells them to stop."""
    context = get_context("spawn")
    stop = context.Event()
    with ProcessPoolExecutor(count, mp_context=context, initializer=prepare_worker, initargs=(stop,)) as pool:
        yield pool, stop


@contextmanager
def interrupts_ignored() -> Iterator[None]:
    """Processes started meanwhile ignore Ctrl-C from their first moment on."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


_stop: Event | None = None


def prepare_worker(stop: Event) -> None:
    """In a new process: one thread for linear algebra, for the processes share the cores already."""
    global _stop
    _stop = stop
    threadpool_limits(1)


def attempt(experiment: Experiment, seed: int, run: int) -> Outcome:
    """One run in a worker."""
    stop = _stop
    try:
        errors = run_once(experiment, np.random.default_rng([seed, run]), stop.is_set if stop else lambda: False)
    except (SolverError, GeometryError) as error:
        return Outcome(run, None, str(error))
    return Outcome(run, errors)


def finished(tasks: dict[Future[Outcome], int], cancelled: Cancelling) -> Iterator[Future[Outcome]]:
    """The tasks as they end. Raises Cancelled as soon as it is asked for."""
    pending = set(tasks)
    while pending:
        done, pending = wait(pending, timeout=POLL, return_when=FIRST_COMPLETED)
        yield from done
        if cancelled():
            raise Cancelled("cancelled before all runs were done")


def write_results(rows: Sequence[Row], out: Path, command: str) -> None:
    """`consistency.json`, `consistency.md` (with the command that makes them) and `consistency.svg` in `out`."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "consistency.json").write_text(json.dumps(figures(rows), indent=2) + "\n", encoding="utf-8")
    (out / "consistency.md").write_text(f"`{command}`\n\n{table(rows)}\n", encoding="utf-8")
    consistency_to_svg(rows, out / "consistency.svg")


def command_of(wanted: Sequence[Experiment], runs: int, seed: int) -> str:
    """The command that gives these rows again."""
    names = {
        "world": [e.world for e in wanted],
        "model": [e.model for e in wanted],
        "backend": [e.back_end for e in wanted],
        "association": [e.association for e in wanted],
    }
    lists = " ".join(f"--{option} {' '.join(dict.fromkeys(chosen))}" for option, chosen in names.items())
    return f"splinescope consistency --runs {runs} {lists} --seed {seed}"


def figures(rows: Sequence[Row]) -> dict[str, Any]:
    """The rows as plain data; what could not be computed is null."""
    return {"rows": [_plain(row) for row in rows]}


def _plain(row: Row) -> dict[str, Any]:
    named = {
        "pose_anees": row.pose,
        "curve_anees": row.curve,
        "nis": row.nis,
        "chi2_per_dof": row.chi2,
        "coverage_2sigma": row.coverage,
    }
    return {
        "world": row.experiment.world,
        "model": row.experiment.model,
        "backend": row.experiment.back_end,
        "association": row.experiment.association,
        "runs": row.runs,
        **{key: _number(value) for name, figure in named.items() for key, value in _with_band(name, figure).items()},
        "position_error": _number(row.position_error),
        "failed": row.failed,
        "problem": row.problem,
    }


def _with_band(name: str, figure: Figure) -> dict[str, float | tuple[float, float]]:
    stem = {"pose_anees": "pose", "curve_anees": "curve", "chi2_per_dof": "chi2", "coverage_2sigma": "coverage"}
    return {name: figure.value, f"{stem.get(name, name)}_band": figure.band}


def _number(value: float | tuple[float, float]) -> Any:
    if isinstance(value, tuple):
        return [_number(each) for each in value]
    return value if math.isfinite(value) else None


HEADERS = (
    "world", "model", "back end", "association", "runs", "pose ANEES", "curve ANEES", "NIS", "χ²/dof", "2σ coverage",
    "position error",
)  # fmt: skip


def table(rows: Sequence[Row]) -> str:
    """The rows as a Markdown table; a figure outside its band carries a mark."""
    cells = [HEADERS, tuple("---" for _ in HEADERS), *(_cells(row) for row in rows)]
    widths = [max(len(line[k]) for line in cells) for k in range(len(HEADERS))]
    filled = [
        [cell.ljust(width, "-" if number == 1 else " ") for cell, width in zip(line, widths, strict=True)]
        for number, line in enumerate(cells)
    ]
    notes = [f"{_name(row.experiment)}: {row.failed} runs failed ({row.problem})" for row in rows if row.failed]
    return "\n".join([*(f"| {' | '.join(line)} |" for line in filled), *(f"\n{note}" for note in notes)])


def _name(experiment: Experiment) -> str:
    return f"{experiment.world}, {experiment.model}, {experiment.back_end}, {experiment.association}"


def _cells(row: Row) -> tuple[str, ...]:
    e = row.experiment
    errors = f"{1e3 * row.position_error:.1f} mm" if math.isfinite(row.position_error) else "–"
    measured = [*(_cell(figure) for figure in (row.pose, row.curve, row.nis)), _cell(row.chi2, digits=3)]
    return (e.world, e.model, e.back_end, e.association, str(row.runs), *measured, _share(row.coverage), errors)


def _cell(figure: Figure, digits: int = 2) -> str:
    """`0.97 (0.85–1.17)`, with a ✗ where it lies outside."""
    if not math.isfinite(figure.value):
        return "–"
    value = f"{figure.value:.3g}" if figure.value >= 10 else f"{figure.value:.{digits}f}"
    low, high = (f"{edge:.{digits}f}" for edge in figure.band)
    return f"{value} ({low}–{high}){'' if figure.inside else ' ✗'}"


def _share(figure: Figure) -> str:
    if not math.isfinite(figure.value):
        return "–"
    low, high = figure.band
    return f"{100 * figure.value:.0f} % ({100 * low:.0f}–{100 * high:.0f}){'' if figure.inside else ' ✗'}"
