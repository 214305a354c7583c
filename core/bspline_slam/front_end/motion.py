"""What the next step will be: odometry made usable, its bias learnt from the matched steps, as long as these say that
it fits; else the motion so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import median

import numpy as np
from jaxtyping import Float

from bspline_slam import se2


@dataclass(frozen=True, slots=True)
class MotionConfig:
    """Noise that odometry starts with, per step (m and rad; shares of distance and turn), and how bias is learnt.

    `guess_…` is the noise of a step that no odometry tells of, `momentum` how much of the turn before it goes on in it,
    and `late_steps` how many steps tell how far the robot usually goes. `trust` is the weight, in squared metres or
    radians of motion, of the belief that odometry has no bias; `distrust` that where it was found not to fit; `memory`
    the share of what was learnt that survives a key step.

    Odometry is judged whenever the robot has moved by `judged_distance` or `judged_turn`: it fits as long as no more
    than `most_unexplained` of the squared motion of late is left unexplained, and again when that is `convincing`;
    `judged_memory` is the share of a judgement that survives the next, and `doubt` what odometry leaves unexplained
    before anything was seen.
    """

    position: float = 0.02
    position_per_metre: float = 0.1
    heading: float = 0.02
    heading_per_metre: float = 0.05
    heading_per_radian: float = 0.1
    guess_position: float = 0.15
    guess_heading: float = 0.3
    momentum: float = 0.5
    late_steps: int = 15
    trust: float = 0.3
    distrust: float = 0.01
    memory: float = 0.995
    least_steps: int = 10
    judged_distance: float = 0.1
    judged_turn: float = np.deg2rad(5.0)
    judged_memory: float = 0.9
    doubt: float = 0.3
    most_unexplained: float = 0.5
    convincing: float = 0.1


@dataclass(frozen=True, eq=False, slots=True)
class OdometryCalibration:
    """Linear map from an odometry step (dx, dy, dθ) to the step really made, learnt by least squares.

    `gram` and `moment` are the accumulated normal equations. `signs` of the three are the prior, held less firmly when
    the odometry of this log was once found not to fit (`distrusted`).
    """

    gram: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))
    moment: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))
    steps: int = 0
    distrusted: bool = False
    signs: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def matrix(self, config: MotionConfig) -> Float[np.ndarray, "3 3"]:
        """The learnt 3 × 3 map; that of the signs until there is something to learn from."""
        start = np.diag(self.signs)
        if self.steps < config.least_steps:
            return start
        held = config.distrust if self.distrusted else config.trust
        return np.linalg.solve(self.gram + held * np.eye(3), self.moment + held * start).T

    def learned(
        self, step: Float[np.ndarray, "3"], matched: Float[np.ndarray, "3"], config: MotionConfig
    ) -> OdometryCalibration:
        """The calibration after one more pair of odometry step and matched step."""
        return replace(
            self,
            gram=config.memory * self.gram + np.outer(step, step),
            moment=config.memory * self.moment + np.outer(step, matched),
            steps=self.steps + 1,
        )


def step_information(step: Float[np.ndarray, "3"], config: MotionConfig) -> Float[np.ndarray, "3 3"]:
    """Information matrix (x, y, θ) of an odometry step."""
    along, heading = step_errors(step, config)
    return np.diag([along**-2, along**-2, heading**-2])


def step_errors(step: Float[np.ndarray, "3"], config: MotionConfig) -> tuple[float, float]:
    """Standard deviations of position (m) and heading (rad) of an odometry step."""
    x, y, turn = step.tolist()
    distance, turn = math.hypot(x, y), abs(turn)
    along = config.position + config.position_per_metre * distance + 0.05 * turn
    return along, config.heading + config.heading_per_metre * distance + config.heading_per_radian * turn


def surprise(off: Float[np.ndarray, "3"], information: Float[np.ndarray, "3 3"]) -> float:
    """Squared Mahalanobis distance of an error."""
    return float(off @ information @ off)


def guess_information(config: MotionConfig) -> Float[np.ndarray, "3 3"]:
    """Information matrix (x, y, θ) of a step guessed without odometry."""
    return np.diag([config.guess_position**-2, config.guess_position**-2, config.guess_heading**-2])


@dataclass(frozen=True, eq=False, slots=True)
class Unexplained:
    """How much of the motion of late odometry leaves unexplained, of position and of heading: frozen wheels all of it,
    reversed ones four times as much (as squares count).

    `squares` (m², rad²) are sums of squared errors of odometry, `moved` of squared motion; usual noise (3 σ) counts as
    motion, so that a straight drive says nothing of turns. `fits` is the verdict.
    """

    squares: Float[np.ndarray, "2"]
    moved: Float[np.ndarray, "2"]
    fits: bool = True

    @classmethod
    def at_start(cls, config: MotionConfig) -> Unexplained:
        """What is expected before anything was seen."""
        moved = np.square([config.judged_distance, config.judged_turn])
        return cls(config.doubt * moved, moved)

    def learned(
        self,
        wheels: Float[np.ndarray, "3"],
        made: Float[np.ndarray, "3"],
        seen: Float[np.ndarray, "3 3"],
        config: MotionConfig,
    ) -> Unexplained:
        """After one more step, `made` as beams with information `seen` (frame of its end) say. Along a direction that
        they leave open, a match only repeats what it was told, which is no evidence."""
        usual = 3.0 * np.array(step_errors(wheels, config))
        noise = np.maximum([0.5 * config.judged_distance, 0.5 * config.judged_turn], usual)
        known, open_way = seen[:2, :2].tolist(), config.position**-2
        motion = _squares(known, open_way, se2.inverse(made)) + noise**2
        squares = np.minimum(_squares(known, open_way, se2.between(made, wheels)), 4.0 * motion)
        squares, motion = config.judged_memory * self.squares + squares, config.judged_memory * self.moved + motion
        limit = config.most_unexplained if self.fits else config.convincing
        return Unexplained(squares, motion, bool((squares <= limit * motion).all()))


def _squares(known: list[list[float]], open_way: float, step: Float[np.ndarray, "3"]) -> Float[np.ndarray, "2"]:
    """Squared length of a step where it is determined, K(K + oI)⁻¹ of it with K `known` and o `open_way` (1/m²), and
    squared turn; numbers one by one, for this is done at every scan."""
    ((a, b), (_, c)), (x, y, turn) = known, step.tolist()
    determinant = (a + open_way) * (c + open_way) - b * b
    u = ((c + open_way) * x - b * y) / determinant
    v = ((a + open_way) * y - b * x) / determinant
    return np.array([(a * u + b * v) ** 2 + (b * u + c * v) ** 2, turn**2])


def guesses(
    wheels: tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]] | None,
    late: Sequence[Float[np.ndarray, "3"]],
    config: MotionConfig,
    *,
    believed: bool,
) -> tuple[Float[np.ndarray, "3"], ...]:
    """Steps worth trying, the most trusted first: `wheels` (odometry calibrated and raw), the usual way of the `late`
    steps with and without a turn, the last of them, and standing still; odometry last where it is not to be
    believed."""
    way = usual_way(late)
    turn = late[-1][2] if late else 0.0
    plain = (np.array([*way, config.momentum * turn]), *late[-1:], np.array([*way, 0.0]), se2.IDENTITY)
    if wheels is None:
        return plain
    return (*wheels, *plain[1:]) if believed else (*plain, *wheels)


def usual_way(late: Sequence[Float[np.ndarray, "3"]]) -> Float[np.ndarray, "2"]:
    """How far, and where to, a robot usually goes in a step: the median of its longer ones, which are at least half as
    long as the longest, for it may have stopped to turn."""
    ways = [(math.hypot(x, y), x, y) for x, y, _ in map(np.ndarray.tolist, late)]
    longest = max(ways, default=(0.0,))[0]
    longer = [way for way in ways if way[0] >= 0.5 * longest]
    return np.array([median(way[axis] for way in longer) if longer else 0.0 for axis in (1, 2)])
