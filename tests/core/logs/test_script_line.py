"""Scripts of the mapper: the same drive whatever way it is told, and what breaks their rules."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bspline_slam.errors import LogError
from bspline_slam.logs import open_log
from bspline_slam.logs.script_line import BadLine, clock_of, script_pose, script_readings

Write = Callable[..., Path]
RANGES = 100.0 + np.arange(180)


def with_clock_lines(k: int) -> list[str]:
    readings = " ".join(f"{r:g}" for r in RANGES)
    clock = f"@SENS 13-08-97 12:00:0{k}.250"
    return [clock, f"#ROBOT {50 * k} 20 90", clock, f"#LASER 180 180: {readings}"]


def with_clocks_inside(k: int) -> list[str]:
    readings = ", ".join(f"{r:g}" for r in RANGES)
    clock = f"13-08-1997 12:00:0{k}.250"
    return [f"POS {clock}: ({50 * k}, 20, 90)", f"LASER-RANGE {clock} 180 180.0: {readings}"]


@pytest.mark.parametrize("told", [with_clock_lines, with_clocks_inside])
def test_a_drive_is_read(told: Callable[[int], list[str]], write_lines: Write) -> None:
    log = open_log(write_lines([line for k in range(5) for line in told(k)]))
    assert len(log) == 5
    assert np.allclose(np.diff(log.times), 1.0)
    assert log[0].stamp % 60 == pytest.approx(0.25)
    assert log.odometry is not None
    assert np.allclose(log.odometry, [[0.5 * k, 0.2, np.pi / 2] for k in range(5)])
    assert np.allclose(log[3].ranges, RANGES / 100)
    assert np.allclose(log[3].bearings, np.radians(np.arange(-90, 90)))
    assert not log[3].pose_robot_sensor.any()


@pytest.mark.parametrize("line", [b"#ROBOT 1 2", b"POS 1 2 north", b"#ROBOT 1 2 nan"])
def test_a_pose_is_three_numbers(line: bytes) -> None:
    with pytest.raises(BadLine):
        script_pose(line.split())


@pytest.mark.parametrize("line", [b"#LASER 3 180: 1 2", b"#LASER", b"#LASER 2 180: 1 x", b"LASER-RANGE 0 180:"])
def test_readings_are_as_many_numbers_as_announced(line: bytes) -> None:
    with pytest.raises(BadLine):
        script_readings(line.split())


def test_a_day_that_is_none_is_told() -> None:
    with pytest.raises(BadLine, match="date or time"):
        clock_of(b"@SENS 33-08-97 12:00:00".split())
    assert clock_of(b"#ROBOT 1 2 3".split()) is None


def test_damage_is_named_with_its_line(write_lines: Write) -> None:
    with pytest.raises(LogError, match=r":2: #LASER announces 3 readings, found 2"):
        open_log(write_lines(["#ROBOT 1 2 3", "#LASER 3 180: 1 2"]))
