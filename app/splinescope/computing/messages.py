"""What goes between the page's process and the estimator's: requests one way, reports the other, all frozen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.lab.scan_consistency import ScanConsistency
from bspline_slam.lab.stretches import Stretches
from bspline_slam.measuring import Measurement, Picked
from bspline_slam.slam import SlamConfig, SlamStep, Snapshot
from splinescope.computing.iterations import Frame
from splinescope.computing.packed_result import PackedResult
from splinescope.computing.solution import Solution
from splinescope.quality import Quality


@dataclass(frozen=True, slots=True)
class LogFile:
    """Where a log lies, and the hash of what the page has read there: it may be another one by now."""

    path: Path
    content_hash: str


@dataclass(frozen=True, slots=True)
class ProcessLog:
    """Run the whole pipeline over a log."""

    job: int
    log: LogFile
    config: SlamConfig


@dataclass(frozen=True, eq=False, slots=True)
class SolveMap:
    """Solve the map of a result made from the log, as its configuration says."""

    job: int
    log: LogFile
    result: PackedResult


@dataclass(frozen=True, eq=False, slots=True)
class FindCovariances:
    """How good the map of a result made from the log is: its residuals, and of a solved one the marginal covariances
    and how consistent it is."""

    job: int
    log: LogFile
    result: PackedResult


@dataclass(frozen=True, eq=False, slots=True)
class MeasureMap:
    """How far two things of the solved map of a result are apart."""

    job: int
    result: PackedResult
    first: Picked
    second: Picked


Request = ProcessLog | SolveMap | FindCovariances | MeasureMap


@dataclass(frozen=True, slots=True)
class Message:
    """What the estimator's process says about job number `job`."""

    job: int


@dataclass(frozen=True, slots=True)
class Progress(Message):
    """How far a job is. `fraction` (0…1) and `seconds_left` are None while nobody can know."""

    stage: str
    fraction: float | None = None
    seconds_left: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class StepsDone(Message):
    """The next scans are processed."""

    steps: tuple[SlamStep, ...]


@dataclass(frozen=True, eq=False, slots=True)
class MapChanged(Message):
    """The map in the middle of processing, for looking at (see `for_looking_at`), adjusted up to so many scans."""

    snapshot: Snapshot
    adjusted: int = 0


@dataclass(frozen=True, eq=False, slots=True)
class Iterated(Message):
    """The solver made an iteration."""

    record: IterationRecord


@dataclass(frozen=True, eq=False, slots=True)
class Finished(Message):
    """A job is done: the map for looking at, the figures of its last solve and some of its iterations, and the whole
    result, None for a job
    without a map. `kept` is the pickled snapshot, which the page only ever hands back: it is too large to unpack there.
    """

    snapshot: Snapshot | None = None
    solution: Solution | None = None
    kept: bytes | None = None
    frames: tuple[Frame, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class QualityFound(Message):
    """What beams leave over of a map, and what it tells of laser and wheels."""

    quality: Quality


@dataclass(frozen=True, eq=False, slots=True)
class CovariancesFound(Message):
    """Covariances of the stacked control points, by spline id, and 1σ across the curves that they give (m)."""

    splines: dict[int, Float[np.ndarray, "d d"]]
    sigmas: Stretches


@dataclass(frozen=True, slots=True)
class Measured(Message):
    """How far two things are apart, or a sentence on why that cannot be told."""

    found: Measurement | str


@dataclass(frozen=True, eq=False, slots=True)
class ConsistencyFound(Message):
    """How the latest solved map stands against the truth and against itself; None where nothing can be tested."""

    tests: ScanConsistency | None


@dataclass(frozen=True, eq=False, slots=True)
class Stopped(Message):
    """A job was cancelled; what it had done by then as in Finished, None if that changes nothing."""

    snapshot: Snapshot | None = None
    kept: bytes | None = None


@dataclass(frozen=True, slots=True)
class Failed(Message):
    """A job could not go on, and why; also said when the process ended with the job undone."""

    sentence: str


def for_looking_at(snapshot: Snapshot) -> Snapshot:
    """A snapshot without what only a solver needs; its steps travel apart from it, a few at a time."""
    return replace(snapshot, steps=(), estimate=None, observations=(), pose_factors=())
