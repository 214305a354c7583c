"""One line of a CARMEN log.

All lines below end in `ipc_timestamp host logger_timestamp`; the first of these is the stamp. A pose is `x y θ`.
`FLASER n r₁…r_n laser_pose odometry_pose` (main laser), `RLASER` alike (rear laser),
`ROBOTLASER1 type start_angle field_of_view resolution max_range accuracy remission_mode n r₁…r_n m e₁…e_m
laser_pose robot_pose tv rv forward_safety side_safety turn_axis`,
`ODOM pose tv rv acceleration`, `TRUEPOS true_pose odometry_pose`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

LASERS = (b"FLASER", b"ROBOTLASER1", b"RLASER")
"""Tags of laser lines in the order of preference: a log is read through the first that it has."""

POSES = (b"ODOM", b"TRUEPOS")

_HEAD = {b"FLASER": 1, b"RLASER": 1, b"ROBOTLASER1": 8}
_LEAST_STEP = 1e-6  # rad
_SANE = 1e12  # seconds, metres: whatever is larger is damage
_TAIL = {b"FLASER": 9, b"RLASER": 9, b"ROBOTLASER1": 14}


class BadLine(Exception):
    """A line breaks the rule that is its text."""


@dataclass(frozen=True, slots=True)
class PoseLine:
    """ODOM or TRUEPOS: where the robot is by odometry, or in truth."""

    stamp: float
    pose: tuple[float, float, float]


@dataclass(frozen=True, eq=False, slots=True)
class LaserLine:
    """Readings of one sweep (m), the robot's pose by odometry and the laser's pose in the same frame.

    `start_angle`, `step` (rad) and `max_range` (m) are None where the line does not say them.
    """

    stamp: float
    pose: tuple[float, float, float]
    laser: tuple[float, float, float]
    readings: Float[np.ndarray, "beams"]
    start_angle: float | None = None
    step: float | None = None
    max_range: float | None = None


def parse_pose(fields: list[bytes]) -> PoseLine:
    """A line of POSES. BadLine when a field is missing or not a number."""
    if len(fields) < 10:
        raise BadLine(f"{fields[0].decode()} needs 9 values, found {len(fields) - 1}")
    values = _numbers(fields, 1, 8)
    return PoseLine(values[6], (values[0], values[1], values[2]))


def parse_laser(fields: list[bytes]) -> LaserLine:
    """A line of LASERS. BadLine when readings are missing or something is not a number; readings may be nan or inf."""
    tag = fields[0].decode()
    head, tail = _HEAD[fields[0]], _TAIL[fields[0]]
    count = _count(fields, head)
    remissions = _count(fields, head + 1 + count) + 1 if head > 1 and len(fields) > head + 1 + count else 0
    present = len(fields) - 1 - head - remissions - tail
    if count == 0:
        raise BadLine(f"{tag} announces no readings")
    if present != count:
        raise BadLine(f"{tag} announces {count} readings, found {max(present, 0)}")
    try:
        readings = np.array(list(map(float, fields[head + 1 : head + 1 + count])))
    except ValueError:
        raise BadLine(f"{tag} has a reading that is not a number") from None
    values = _numbers(fields, len(fields) - tail, len(fields) - tail + 6)
    stamp = _numbers(fields, len(fields) - 3, len(fields) - 2)[0]
    laser, pose = (values[0], values[1], values[2]), (values[3], values[4], values[5])
    if head == 1:
        return LaserLine(stamp, pose, laser, readings)
    start, fov, step, max_range = _numbers(fields, 2, 6)
    step = step or fov / max(count - 1, 1)
    if step == 0:
        return LaserLine(stamp, pose, laser, readings, max_range=max_range)
    if not _LEAST_STEP <= abs(step) <= math.pi:
        raise BadLine(f"{tag} has an angular resolution of {step:g} rad")
    return LaserLine(stamp, pose, laser, readings, start, step, max_range)


def _count(fields: list[bytes], place: int) -> int:
    try:
        count = int(fields[place])
    except (ValueError, IndexError):
        count = -1
    if count < 0:
        raise BadLine(f"{fields[0].decode()} does not say how many readings it has")
    return count


def _numbers(fields: list[bytes], first: int, beyond: int) -> list[float]:
    """Numbers of a sane size from fields[first:beyond]."""
    try:
        values = [float(field) for field in fields[first:beyond]]
    except ValueError:
        values = [math.nan]
    if not all(abs(value) < _SANE for value in values):
        raise BadLine(f"{fields[0].decode()} has a pose or stamp that is not a number")
    return values
