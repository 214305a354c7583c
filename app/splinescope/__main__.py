"""The command line: view, run, evaluate, simulate, twin, join, consistency. Everything that prints is here."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

from bspline_slam.errors import Cancelled, SplineSlamError

SAMPLE = "office"
FAILED, INTERRUPTED = 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; every error that is meant for a person becomes one sentence and exit code 2."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or (words[0].startswith("-") and words[0] not in ("-h", "--help", "--version")):
        words.insert(0, "view")
    options = parser().parse_args(words)
    try:
        options.command(options)
    except Cancelled as stop:
        return _complain(str(stop), INTERRUPTED)
    except SplineSlamError as error:
        return _complain(str(error), FAILED)
    except OSError as error:
        return _complain(f"{error.filename or 'a file'}: {error.strerror}", FAILED)
    except KeyboardInterrupt:
        return _complain("stopped", INTERRUPTED)
    return 0


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = argparse.ArgumentParser(
        prog="splinescope",
        description="A browser workbench for B-spline SLAM on 2D laser logs. Without a command: view the sample log.",
    )
    top.add_argument("--version", action="version", version=f"splinescope {version('splinescope')}")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    _add_view(commands.add_parser("view", help="watch a log being processed, in the browser"))
    _add_run(commands.add_parser("run", help="process a log without a display and write trajectory, map and report"))
    _add_evaluate(commands.add_parser("evaluate", help="score a finished run: its trajectory and its map"))
    _add_simulate(commands.add_parser("simulate", help="drive a simulated robot through a world and write its log"))
    _add_twin(
        commands.add_parser("twin", help="simulate a finished run again and hold new estimates against the truth")
    )
    _add_join(commands.add_parser("join", help="join local point-feature maps made elsewhere into one"))
    _add_consistency(commands.add_parser("consistency", help="simulate many runs and hold errors against covariances"))
    _add_reproduce(commands.add_parser("reproduce", help="do the experiments of the paper again: figures and a table"))
    return top


def _add_view(command: argparse.ArgumentParser) -> None:
    meaning = f"a log, or the name of a sample (default: the session's, else {SAMPLE})"
    command.add_argument("log", nargs="?", help=meaning)
    command.add_argument("--host", default="127.0.0.1", help="address to listen on (default: %(default)s)")
    command.add_argument("--port", type=int, default=8080, help="port to listen on, 0 for any (default: %(default)s)")
    command.add_argument("--no-browser", action="store_true", help="only print the address")
    command.add_argument("--session", type=Path, help="a session file to go on with")
    command.set_defaults(command=view)


def _add_run(command: argparse.ArgumentParser) -> None:
    command.add_argument("log", help="a log, or the name of a sample")
    command.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    command.add_argument("--backend", help="solver: direct, sam, isam2, islsjf, ekf, bs_slam, idmj or pose_graph")
    command.add_argument("--model", help="observation model: normal-distance or chord-length")
    command.add_argument("--config", type=Path, help="configuration, .json or .toml; a written report.json has it all")
    command.add_argument("--edits", type=Path, metavar="JOURNAL", help="hand edits to make, as the page wrote them")
    command.set_defaults(command=run)


def _add_evaluate(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="the folder that `run` wrote, or a TUM file")
    command.add_argument("--relations", type=Path, help="hand-checked relative poses: t1 t2 x y z roll pitch yaw")
    command.add_argument("--reference", type=Path, help="a reference trajectory (TUM) for ATE and RPE")
    command.add_argument("--log", type=Path, help="the log of the run, to hold the map against its beams")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command=evaluate)


def _add_simulate(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "world", nargs="?", help="a world: the name of one that comes with the program, or a .json file"
    )
    command.add_argument("--from-map", type=Path, metavar="DIR", help="instead: the map and the path that `run` wrote")
    command.add_argument("--log", type=Path, help="the log that DIR was made from, to scan exactly where it does")
    command.add_argument("--out", type=Path, required=True, help="the log to write; its suffix says the format")
    command.add_argument("--seed", type=int, default=0, help="of all noise (default: %(default)s)")
    command.add_argument("--noise", type=float, default=0.012, help="of ranges, m (default: %(default)s)")
    command.add_argument("--resolution", type=float, help="between beams, degrees (default: the world's own)")
    command.add_argument(
        "--odometry-noise", type=float, default=1.0, help="factor on its errors (default: %(default)s)"
    )
    command.set_defaults(command=simulate)


def _add_twin(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, metavar="DIR", help="the folder that `run` wrote")
    command.add_argument("--log", type=Path, help="the log that DIR was made from, to scan exactly where it does")
    command.add_argument("--seeds", type=int, default=5, metavar="N", help="how many drives (default: %(default)s)")
    command.add_argument("--seed", type=int, default=0, help="of the first drive (default: %(default)s)")
    command.add_argument("--scans", metavar="FIRST:LAST", help="only a stretch of the drive (default: all of it)")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command=twin)


def _add_join(command: argparse.ArgumentParser) -> None:
    command.add_argument("maps", type=Path, help="local maps, .npz: x0, P0, id0, x1, …")
    command.add_argument("--out", type=Path, required=True, help="folder for joint.npz; made when missing")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command=join)


def _add_consistency(command: argparse.ArgumentParser) -> None:
    command.add_argument("--runs", type=int, default=100, help="of each experiment (default: %(default)s)")
    for option, default, meaning in (
        ("--world", ["three_splines", "corridor"], "worlds to drive through, by name or file"),
        ("--model", ["normal-distance"], "observation models: normal-distance, chord-length"),
        ("--backend", ["direct"], "estimators to compare"),
        ("--association", ["truth", "automatic"], "who says which beam met which curve: truth, automatic"),
    ):
        given = f"{meaning} (default: {' '.join(default)})"
        command.add_argument(option, nargs="+", metavar="NAME", default=default, help=given)
    command.add_argument("--out", type=Path, help="folder for table, JSON and drawing; made when missing")
    command.add_argument("--seed", type=int, default=0, help="of all noise (default: %(default)s)")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command=consistency)


def _add_reproduce(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--out", type=Path, default=Path("reproduction"), help="folder for SVG, PNG and JSON (default: %(default)s)"
    )
    command.add_argument("--figure", type=int, metavar="N", help="only this figure of the paper, 1 to 9")
    command.add_argument(
        "--intel", metavar="PATH", help="the Intel log, which figure 9 is made from (or any other log)"
    )
    command.set_defaults(command=reproduce)


def view(options: argparse.Namespace) -> None:
    """Serve the page until it is stopped."""
    from splinescope.paths import find_log

    log = find_log(options.log or log_of_session(options.session) or SAMPLE)
    from splinescope import viewer

    viewer.view(
        log,
        host=options.host,
        port=options.port,
        browser=not options.no_browser and has_display(),
        session=options.session,
    )


def log_of_session(session: Path | None) -> str | None:
    """The path of the log that a session's file refers to. Raises ConfigError where that is gone."""
    from bspline_slam.errors import ConfigError
    from splinescope.browser.preferences import load

    log = load(session).log if session is not None else ""
    if log and not Path(log).exists():
        raise ConfigError(f"the session {session} is about {log}, which is gone: say where the log is now")
    return log or None


def has_display() -> bool:
    """Whether a browser would open a window of its own; in a bare terminal it would take over that terminal."""
    return sys.platform == "darwin" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def run(options: argparse.Namespace) -> None:
    """Process a whole log and write its results."""
    from splinescope.command_line.run import run_and_write, summary_text
    from splinescope.paths import find_log

    with cancelled_by_interrupt() as cancelled, progress_line() as progress:
        summary = run_and_write(
            find_log(options.log),
            options.out,
            config_file=options.config,
            back_end=options.backend,
            model=options.model,
            edits=options.edits,
            progress=progress,
            cancelled=cancelled,
        )
    print(summary_text(summary, options.out))


def evaluate(options: argparse.Namespace) -> None:
    """Print the figures of a finished run."""
    from splinescope.command_line.evaluate import evaluate_results, evaluation_text

    figures = evaluate_results(
        options.results, relations=options.relations, reference=options.reference, log=options.log
    )
    print(json.dumps(figures, indent=2) if options.json else evaluation_text(figures))


def simulate(options: argparse.Namespace) -> None:
    """Write the log of a simulated drive."""
    from splinescope.command_line.simulate import simulate_as_wished

    with progress_line() as progress:
        written = simulate_as_wished(options, lambda done, total: progress("Simulating scans", done / total))
    print(*written, sep="\n")


def twin(options: argparse.Namespace) -> None:
    """Print how far estimates are from the truth of a twin, a line for each seed."""
    from splinescope.command_line import twin_table as table
    from splinescope.command_line.twin import run_trials
    from splinescope.command_line.twin_source import chosen_stretch, read_twin

    world = chosen_stretch(read_twin(options.results, options.log), options.scans)
    seeds = range(options.seed, options.seed + options.seeds)

    def show(line: str) -> None:
        if not options.json:
            print(line, flush=True)

    with cancelled_by_interrupt() as cancelled, progress_line() as progress:
        trials = run_trials(world, seeds, progress, cancelled, show)
    print(json.dumps(table.figures(seeds, trials), indent=2) if options.json else table.closing(trials))


def join(options: argparse.Namespace) -> None:
    """Join local maps and write the joint one."""
    from splinescope.command_line.join import join_and_write, joined_text

    with cancelled_by_interrupt() as cancelled, progress_line() as progress:
        figures = join_and_write(options.maps, options.out, progress=progress, cancelled=cancelled)
    print(json.dumps(figures, indent=2) if options.json else joined_text(figures, options.out))


def consistency(options: argparse.Namespace) -> None:
    """Print how honest covariances are, as a table or as JSON."""
    from splinescope.command_line import consistency as study

    wanted = study.experiments(options.world, options.model, options.backend, options.association)
    with cancelled_by_interrupt() as cancelled, progress_line() as progress:
        rows = study.run_experiments(wanted, options.runs, options.seed, progress, cancelled)
    if options.out:
        study.write_results(rows, options.out, study.command_of(wanted, options.runs, options.seed))
    print(json.dumps(study.figures(rows), indent=2) if options.json else study.table(rows))


def reproduce(options: argparse.Namespace) -> None:
    """Draw the figures of the paper from experiments done now, and print what they say."""
    from splinescope.command_line.reproduce import reproduce_and_describe
    from splinescope.paths import find_log

    log = find_log(options.intel) if options.intel else None
    with cancelled_by_interrupt() as cancelled, progress_line() as progress:
        described = reproduce_and_describe(options.out, options.figure, log, progress, cancelled)
    print(described)


@contextmanager
def progress_line() -> Iterator[Callable[[str, float], None]]:
    """Progress on standard error, where results do not go."""
    from splinescope.command_line.progress import ProgressLine

    line = ProgressLine(sys.stderr)
    try:
        yield line
    finally:
        line.end()


@contextmanager
def cancelled_by_interrupt() -> Iterator[Callable[[], bool]]:
    """Ctrl-C asks the job to stop at its next safe point; a second one stops at once."""
    asked = threading.Event()

    def ask(number: int, frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)


def _complain(sentence: str, code: int) -> int:
    print(f"splinescope: {sentence}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
