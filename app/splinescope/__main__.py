"""The command line, a function for each command. Everything that commands print is printed here."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence

from bspline_slam.errors import Cancelled, SplineSlamError
from splinescope.command_line.interrupt import cancelled_by_interrupt
from splinescope.command_line.options import parser
from splinescope.command_line.progress import progress_line

FAILED, INTERRUPTED = 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; every error that is meant for a person becomes one sentence and exit code 2."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or (words[0].startswith("-") and words[0] not in ("-h", "--help", "--version")):
        words.insert(0, "view")
    options = parser().parse_args(words)
    try:
        COMMANDS[options.command](options)
    except Cancelled as stop:
        return _complain(str(stop), INTERRUPTED)
    except SplineSlamError as error:
        return _complain(str(error), FAILED)
    except OSError as error:
        return _complain(f"{error.filename or 'a file'}: {error.strerror}", FAILED)
    except KeyboardInterrupt:
        return _complain("stopped", INTERRUPTED)
    return 0


def view(options: argparse.Namespace) -> None:
    """Serve the page until it is stopped."""
    from splinescope.log_choice import first_log

    log = first_log(options.log, options.session)
    from splinescope import viewer

    viewer.view(
        log,
        host=options.host,
        port=options.port,
        browser=not options.no_browser and has_display(),
        session=options.session,
    )


def has_display() -> bool:
    """Whether a browser would open a window of its own; in a bare terminal it would take over that terminal."""
    return sys.platform == "darwin" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def run(options: argparse.Namespace) -> None:
    """Process a whole log and write its results."""
    from splinescope.command_line.imports import lasting

    with lasting():
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


COMMANDS: dict[str, Callable[[argparse.Namespace], None]] = {
    command.__name__: command for command in (view, run, evaluate, simulate, twin, join, consistency, reproduce)
}


def _complain(sentence: str, code: int) -> int:
    print(f"splinescope: {sentence}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
