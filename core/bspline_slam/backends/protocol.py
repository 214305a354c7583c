"""What every back end takes and gives: progress, cancelling, one record per iteration, covariances on request."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float

from bspline_slam.errors import Cancelled
from bspline_slam.graph import Graph


@dataclass(frozen=True, eq=False, slots=True)
class IterationRecord:
    """One iteration: cost ½Σρ after it, size of its step, wall time since the start, and the state it reached."""

    index: int
    cost: float
    step_norm: float
    largest_move: float
    seconds: float
    poses: Float[np.ndarray, "n 3"]
    control_points: Float[np.ndarray, "N 2"]


@dataclass(frozen=True, eq=False, slots=True)
class Estimate:
    """The optimum that a back end reached; `iterations[0]` is the starting state.

    `chi2` is Σ‖e‖² of what was measured with robust weights applied, and `dof` the measured numbers less the
    parameters that they determine; gauges and priors count in neither.
    """

    graph: Graph
    poses: Float[np.ndarray, "n 3"]
    control_points: Float[np.ndarray, "N 2"]
    iterations: tuple[IterationRecord, ...]
    converged: bool
    chi2: float
    dof: float


@dataclass(frozen=True, eq=False, slots=True)
class Marginals:
    """Marginal covariances: poses (x, y, θ) by pose index, control points (c_1x, c_1y, c_2x, …) by spline id."""

    poses: dict[int, Float[np.ndarray, "3 3"]]
    splines: dict[int, Float[np.ndarray, "d d"]]


T = TypeVar("T")
Progress = Callable[[IterationRecord], None]
Cancelling = Callable[[], bool]


def silent(record: IterationRecord) -> None:
    """Progress that nobody watches."""


def never() -> bool:
    """A job that nobody cancels."""
    return False


def unless_cancelled(cancelled: Cancelling, wanted: Iterable[T]) -> Iterator[T]:
    """What is wanted, one by one. Raises Cancelled before the first that nobody waits for any more."""
    for each in wanted:
        if cancelled():
            raise Cancelled("the covariances were cancelled")
        yield each


@runtime_checkable
class BackEnd(Protocol):
    """A solver of graphs. Once `cancelled()` is true, `solve` raises Cancelled within an iteration, and `covariances`
    between the blocks it is asked for. Progress is told of every iteration, and where these come after something else
    that takes long, of that too."""

    name: str

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate: ...

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals: ...
