"""The command `simulate`: a drive through a world, or through the map of a finished run, as a log with its truth."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import numpy as np

from bspline_slam.errors import ConfigError
from bspline_slam.lab.simulation import Progress, check_wishes, simulate_to_file, write_simulated
from bspline_slam.lab.twin import simulate_twin
from splinescope.command_line.twin_source import read_twin


def simulate_as_wished(options: Namespace, progress: Progress) -> list[Path]:
    """What the options of the command ask for; returns the files written. Raises the library's errors."""
    if (options.world is None) == (options.from_map is None):
        raise ConfigError("simulate needs either a world or --from-map DIR")
    if options.from_map is None:
        if options.log is not None:
            raise ConfigError("--log goes with --from-map: a world needs no log")
        return simulate_to_file(
            options.world,
            options.out,
            seed=options.seed,
            noise=options.noise,
            resolution_deg=options.resolution,
            odometry_noise=options.odometry_noise,
            progress=progress,
        )
    if options.resolution is not None:
        raise ConfigError("--resolution goes with a world: the twin of a run has the beams of its log")
    return twin_to_file(options, progress)


def twin_to_file(options: Namespace, progress: Progress) -> list[Path]:
    """The twin of a finished run as a log with its truth."""
    check_wishes(options.out, noise=options.noise, odometry_noise=options.odometry_noise, seed=options.seed)
    log = simulate_twin(
        read_twin(options.from_map, options.log),
        rng=np.random.default_rng(options.seed),
        noise=options.noise,
        odometry_noise=options.odometry_noise,
        progress=progress,
    )
    return write_simulated(log, options.out)
