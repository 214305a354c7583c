"""Steps that nothing tells in some direction are found, whatever way they lead."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.calibration.open_steps import OPEN, open_steps
from bspline_slam.graph import PoseFactor


def factor(i: int, j: int, sigmas: tuple[float, float, float], turn: float, kind: str) -> PoseFactor:
    frame = np.eye(3)
    frame[:2, :2] = se2.rotation(turn)
    return PoseFactor(i, j, np.array([0.5, 0.0, 0.0]), np.diag(1.0 / np.array(sigmas)) @ frame, kind)


@pytest.mark.parametrize("turn", [0.0, 0.8, 2.5])
def test_a_step_is_open_where_nothing_tells_of_one_direction(turn: float) -> None:
    scans = np.array([0, 4, 9, 13, 20])
    corridor, wheels = (3.0 * OPEN, 0.01, 0.003), (0.3 * OPEN, 0.3 * OPEN, 0.05)
    factors = [
        factor(0, 1, (0.01, 0.01, 0.003), turn, "matching"),
        factor(1, 2, corridor, turn, "matching"),
        factor(2, 3, corridor, turn, "matching"),
        factor(2, 3, wheels, turn, "odometry"),
        factor(0, 4, (0.01, 0.01, 0.003), turn, "loop"),
    ]
    assert open_steps(factors, scans) == (9, 20)
    assert open_steps([], scans[:1]) == ()
