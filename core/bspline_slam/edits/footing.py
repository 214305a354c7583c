"""A solved problem made ready for edits: what is known of it where it was solved, and its Cholesky factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.edits.descent import Packed
from bspline_slam.edits.ground import Ground


@dataclass(frozen=True, eq=False, slots=True)
class Footing:
    """The problem of a ground: its optimum with the cost there, and a Cholesky factor of Newton's matrix nearby."""

    ground: Ground
    problem: Packed
    state: State
    cost: float
    factor: Factor

    @classmethod
    def of(cls, ground: Ground) -> Footing:
        """Factorise the problem of a ground at its estimate."""
        problem = Packed.of(ground.estimate.graph)
        state = State(ground.estimate.poses, ground.estimate.control_points)
        return cls(ground, problem, state, problem.cost(state), problem.analysed(state).linearise(state).newton())

    @property
    def unknowns(self) -> int:
        """How many unknowns the problem has."""
        return self.state.poses.size + self.state.control_points.size

    def gradient_at(self, state: State) -> Float[np.ndarray, "u"]:
        """The gradient of the cost at some state, by poses and then by control points."""
        gradient = self.problem.gradient(state)
        return np.concatenate([gradient.poses.ravel(), gradient.control_points.ravel()])
