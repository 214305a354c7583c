"""Iterations of a solve are looked at one by one, and those of another solve are not those of this one."""

from __future__ import annotations

import numpy as np

from splinescope.computing.iterations import Frame
from splinescope.replay import Replay


def frames(count: int) -> tuple[Frame, ...]:
    return tuple(Frame(k, 10.0 - k, np.zeros((1, 3)), np.zeros((4, 2))) for k in range(count))


def test_steps_stay_between_the_first_iteration_and_the_result() -> None:
    replay, five = Replay(), frames(5)
    assert replay.number(five) is None
    seen = []
    for by in (-1, -1, -10, 1, 10, 1):
        replay.step(five, by)
        seen.append(replay.number(five))
    assert seen == [3, 2, 0, 1, None, None]


def test_another_solve_begins_with_its_result() -> None:
    replay, five = Replay(), frames(5)
    replay.show(five, 2)
    assert replay.number(five) == 2
    assert replay.number(frames(5)) is None
    replay.show(five, None)
    assert replay.number(five) is None
