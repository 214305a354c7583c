"""Odometry made usable: its bias is learnt from the matched steps, and its noise from what the bias does not
explain."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from bspline_slam import se2


@dataclass(frozen=True, slots=True)
class MotionConfig:
    """Noise that odometry starts with, per step (m and rad; shares of distance and turn), and how bias is learnt.

    `guess_…` is the noise of a step that no odometry tells of. `trust` is the weight, in squared metres or radians of
    motion, of the belief that odometry has no bias; `memory` the share of what was learnt that survives a step.
    """

    position: float = 0.02
    position_per_metre: float = 0.1
    heading: float = 0.02
    heading_per_metre: float = 0.05
    heading_per_radian: float = 0.1
    guess_position: float = 0.3
    guess_heading: float = 0.3
    trust: float = 0.3
    memory: float = 0.995
    least_steps: int = 10


@dataclass(frozen=True, eq=False, slots=True)
class OdometryCalibration:
    """Linear map from an odometry step (dx, dy, dθ) to the step really made, learnt by least squares.

    `gram` and `moment` are the accumulated normal equations; the identity is the prior.
    """

    gram: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))
    moment: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))
    steps: int = 0

    def matrix(self, config: MotionConfig) -> Float[np.ndarray, "3 3"]:
        """The learnt 3 × 3 map; the identity until there is something to learn from."""
        if self.steps < config.least_steps:
            return np.eye(3)
        prior = config.trust * np.eye(3)
        return np.linalg.solve(self.gram + prior, self.moment + prior).T

    def corrected(self, step: Float[np.ndarray, "3"], config: MotionConfig) -> Float[np.ndarray, "3"]:
        """An odometry step with the learnt bias taken out."""
        return self.matrix(config) @ step

    def learned(
        self, step: Float[np.ndarray, "3"], matched: Float[np.ndarray, "3"], config: MotionConfig
    ) -> OdometryCalibration:
        """The calibration after one more pair of odometry step and matched step."""
        return OdometryCalibration(
            config.memory * self.gram + np.outer(step, step),
            config.memory * self.moment + np.outer(step, matched),
            self.steps + 1,
        )


def step_information(step: Float[np.ndarray, "3"], config: MotionConfig) -> Float[np.ndarray, "3 3"]:
    """Information matrix (x, y, θ) of an odometry step."""
    distance, turn = float(np.hypot(step[0], step[1])), abs(float(step[2]))
    along = config.position + config.position_per_metre * distance + 0.05 * turn
    heading = config.heading + config.heading_per_metre * distance + config.heading_per_radian * turn
    return np.diag([along**-2, along**-2, heading**-2])


def guess_information(config: MotionConfig) -> Float[np.ndarray, "3 3"]:
    """Information matrix (x, y, θ) of a step guessed without odometry."""
    return np.diag([config.guess_position**-2, config.guess_position**-2, config.guess_heading**-2])


def guesses(
    odometry_step: Float[np.ndarray, "3"] | None,
    last_step: Float[np.ndarray, "3"],
    calibration: OdometryCalibration,
    config: MotionConfig,
) -> tuple[Float[np.ndarray, "3"], ...]:
    """Steps worth trying, the most trusted first: odometry (calibrated, raw), constant velocity, standing still."""
    if odometry_step is None:
        return last_step, se2.IDENTITY
    corrected = calibration.corrected(odometry_step, config)
    return corrected, odometry_step, last_step, se2.IDENTITY
