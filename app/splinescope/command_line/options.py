"""The words that the command line understands: every command and its options."""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path

from splinescope.paths import SAMPLE


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
    command.set_defaults(command="view")


def _add_run(command: argparse.ArgumentParser) -> None:
    command.add_argument("log", help="a log, or the name of a sample")
    command.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    command.add_argument("--backend", help="solver: direct, sam, isam2, islsjf, ekf, bs_slam, idmj or pose_graph")
    command.add_argument("--model", help="observation model: normal-distance or chord-length")
    command.add_argument("--config", type=Path, help="configuration, .json or .toml; a written report.json has it all")
    command.add_argument("--edits", type=Path, metavar="JOURNAL", help="hand edits to make, as the page wrote them")
    command.set_defaults(command="run")


def _add_evaluate(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="the folder that `run` wrote, or a TUM file")
    command.add_argument("--relations", type=Path, help="hand-checked relative poses: t1 t2 x y z roll pitch yaw")
    command.add_argument("--reference", type=Path, help="a reference trajectory (TUM) for ATE and RPE")
    command.add_argument("--log", type=Path, help="the log of the run, to hold the map against its beams")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command="evaluate")


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
    command.set_defaults(command="simulate")


def _add_twin(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, metavar="DIR", help="the folder that `run` wrote")
    command.add_argument("--log", type=Path, help="the log that DIR was made from, to scan exactly where it does")
    command.add_argument("--seeds", type=int, default=5, metavar="N", help="how many drives (default: %(default)s)")
    command.add_argument("--seed", type=int, default=0, help="of the first drive (default: %(default)s)")
    command.add_argument("--scans", metavar="FIRST:LAST", help="only a stretch of the drive (default: all of it)")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command="twin")


def _add_join(command: argparse.ArgumentParser) -> None:
    command.add_argument("maps", type=Path, help="local maps, .npz: x0, P0, id0, x1, …")
    command.add_argument("--out", type=Path, required=True, help="folder for joint.npz; made when missing")
    command.add_argument("--json", action="store_true", help="print the figures as JSON")
    command.set_defaults(command="join")


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
    command.set_defaults(command="consistency")


def _add_reproduce(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--out", type=Path, default=Path("reproduction"), help="folder for SVG, PNG and JSON (default: %(default)s)"
    )
    command.add_argument("--figure", type=int, metavar="N", help="only this figure of the paper, 1 to 9")
    command.add_argument(
        "--intel", metavar="PATH", help="the Intel log, which figure 9 is made from (or any other log)"
    )
    command.set_defaults(command="reproduce")
