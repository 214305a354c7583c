"""The loop that all batch back ends share: Gauss-Newton (or better, where a problem offers it), damped as
Levenberg-Marquardt where a step would climb.

Unobserved directions (a control point that no beam touched, a wall along itself) do not stop it: each step is held
by an information of `STEP_INFORMATION` per m² or rad², i.e. σ = 1 km, which moves no optimum and leaves what
nothing observes where it started. In covariances the same term shows such a direction as what it is: unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.protocol import Cancelling, IterationRecord, Progress
from bspline_slam.errors import Cancelled, SolverError

STEP_INFORMATION = 1e-6
ROUNDING = 1e-11
"""Costs that differ by less than this fraction are equal."""
LARGEST_DAMPING = 1e14


@dataclass(frozen=True, slots=True)
class Stopping:
    """Converged once a step changes the cost by less than `decrease` of it and no unknown by more than `move`."""

    decrease: float = 1e-9
    move: float = 1e-7
    iterations: int = 100


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """Poses (x, y, θ) and control points, both in the world frame."""

    poses: Float[np.ndarray, "n 3"]
    control_points: Float[np.ndarray, "N 2"]

    def moved(self, step: State) -> State:
        """The state after a step, angles wrapped."""
        poses = self.poses + step.poses
        poses[:, 2] = se2.wrap(poses[:, 2])
        return State(poses, self.control_points + step.control_points)

    @property
    def norm(self) -> float:
        return float(np.sqrt(np.sum(self.poses**2) + np.sum(self.control_points**2)))

    @property
    def largest(self) -> float:
        """Largest absolute entry."""
        return float(max(np.abs(self.poses).max(initial=0.0), np.abs(self.control_points).max(initial=0.0)))


@runtime_checkable
class Linearised(Protocol):
    """A problem near one state: gradient and Gauss-Newton matrix H."""

    def step(self, damping: float) -> State:
        """Solve (H + (STEP_INFORMATION + damping)·I) step = −gradient. Raises SolverError where it is singular.

        Undamped it may be the step of Newton, which knows how residuals bend: it squares what is left to go, where
        Gauss-Newton takes a share of it that weakly held curves make small.
        """
        ...


@runtime_checkable
class Problem(Protocol):
    """What the loop needs to know."""

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²)."""
        ...

    def linearise(self, state: State) -> Linearised: ...


@dataclass(frozen=True, eq=False, slots=True)
class Descent:
    """Where the loop ended and how it came there."""

    state: State
    records: tuple[IterationRecord, ...]
    converged: bool


def descend(problem: Problem, start: State, stopping: Stopping, progress: Progress, cancelled: Cancelling) -> Descent:
    """Lower the cost from `start` until it converges; the cost of a record is never above that of the one before."""
    began = perf_counter()
    state, cost, damping = start, problem.cost(start), 0.0
    if not np.isfinite(cost):
        raise SolverError("the problem holds values that are not finite numbers")
    records = [IterationRecord(0, cost, 0.0, 0.0, 0.0, start.poses, start.control_points)]
    progress(records[0])
    for index in range(1, stopping.iterations + 1):
        if cancelled():
            raise Cancelled(f"the optimisation was cancelled after {index - 1} iterations")
        step, new, new_cost, damping = _descending_step(problem, state, cost, damping, stopping.move)
        largest_move = float(np.linalg.norm(step.poses[:, :2], axis=1).max(initial=0.0))
        elapsed = perf_counter() - began
        record = IterationRecord(index, new_cost, step.norm, largest_move, elapsed, new.poses, new.control_points)
        records.append(record)
        progress(record)
        decrease, state, cost = cost - new_cost, new, new_cost
        if decrease <= stopping.decrease * cost + ROUNDING and step.largest <= stopping.move and damping == 0.0:
            return Descent(state, tuple(records), True)
    return Descent(state, tuple(records), False)


def _descending_step(
    problem: Problem, state: State, cost: float, damping: float, rest: float
) -> tuple[State, State, float, float]:
    """The least damped step that does not climb: the step, the state and cost behind it, the damping to go on with.

    An undamped step of less than `rest` that climbs is rounding: the state is the optimum and stays.
    """
    linearised = problem.linearise(state)
    while True:
        try:
            step = linearised.step(damping)
        except SolverError:
            if damping > LARGEST_DAMPING:
                raise
        else:
            new = state.moved(step)
            new_cost = problem.cost(new)
            if new_cost <= cost + ROUNDING * (1.0 + cost):
                return step, new, new_cost, damping / 10 if damping > 1e-2 else 0.0
            if damping == 0.0 and step.largest <= rest:
                return step, state, cost, 0.0
        if damping > LARGEST_DAMPING:
            raise SolverError(f"no step lowers the cost of {cost:.6g}: its terms are too far apart for the arithmetic")
        damping = max(10 * damping, 1.0)
