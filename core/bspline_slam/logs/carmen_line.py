"""One line of a CARMEN log.

All lines below end in `ipc_timestamp host logger_timestamp`; the first of these is the stamp, and some logs have no
more. A pose is `x y θ`.
`FLASER n r₁…r_n laser_pose odometry_pose` (main laser), `RLASER` alike (rear laser),
`RAWLASER1 type start_angle field_of_view resolution max_range accuracy remission_mode n r₁…r_n m e₁…e_m` (to
`RAWLASER4`), `ROBOTLASER1` alike with `laser_pose robot_pose tv rv forward_safety side_safety turn_axis` after it (and
`ROBOTLASER2`), `LASER_READING n r₁…r_n odometry_pose` (files of GMapping),
`ODOM pose tv rv acceleration`, `TRUEPOS true_pose odometry_pose`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.logs.script_line import SCRIPT_LASERS, BadLine, script_readings

_PLAIN = {b"FLASER": 6, b"RLASER": 6, b"LASER_READING": 3}
_DESCRIBED = {b"ROBOTLASER1": 11, b"ROBOTLASER2": 11} | {b"RAWLASER%d" % number: 0 for number in range(1, 5)}
_BEFORE_CLOCK = _PLAIN | _DESCRIBED  # fields between readings and stamp

LASERS = (
    b"FLASER", b"ROBOTLASER1", b"RLASER", b"ROBOTLASER2", *(tag for tag in _DESCRIBED if tag.startswith(b"RAW")),
    b"LASER_READING", *SCRIPT_LASERS,
)  # fmt: skip
"""Tags of laser lines in the order of preference: a log is read through the first that it has."""
SAYS_ANGLES = tuple(_DESCRIBED)
"""Tags of lines that say where their beams point."""

POSES = (b"ODOM", b"TRUEPOS")

_LEAST_STEP = 1e-6  # rad
_SANE = 1e12  # seconds, metres: whatever is larger is damage


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
    """A line of LASERS. BadLine when readings are missing or something is not a number; readings may be nan or inf.
    Lines of scripts leave stamp and poses to those around them."""
    if fields[0] in SCRIPT_LASERS:
        return LaserLine(0.0, NOWHERE, NOWHERE, script_readings(fields))
    tag, head = fields[0].decode(), 8 if fields[0] in _DESCRIBED else 1
    count = _count(fields, head)
    remissions = _count(fields, head + 1 + count) + 1 if head > 1 and len(fields) > head + 1 + count else 0
    first, beyond = head + 1, head + 1 + count
    place = beyond + remissions  # of the poses
    clock = place + _BEFORE_CLOCK[fields[0]]
    if count == 0:
        raise BadLine(f"{tag} announces no readings")
    if len(fields) - clock != 3 and not (len(fields) - clock == 1 and _are_numbers(fields[place:])):
        present = len(fields) - 3 - (clock - count)
        raise BadLine(f"{tag} announces {count} readings, found {max(present, 0)}")
    try:
        readings = np.array(list(map(float, fields[first:beyond])))
    except ValueError:
        raise BadLine(f"{tag} has a reading that is not a number") from None
    stamp = _numbers(fields, clock, clock + 1)[0]
    laser, pose = _poses(_numbers(fields, place, min(clock, place + 6)))
    if head == 1:
        return LaserLine(stamp, pose, laser, readings)
    start, fov, step, max_range = _numbers(fields, 2, 6)
    step = step or fov / max(count - 1, 1)
    if step == 0:
        return LaserLine(stamp, pose, laser, readings, max_range=max_range)
    if not _LEAST_STEP <= abs(step) <= math.pi:
        raise BadLine(f"{tag} has an angular resolution of {step:g} rad")
    return LaserLine(stamp, pose, laser, readings, start, step, max_range)


NOWHERE = (0.0, 0.0, 0.0)


def _poses(values: list[float]) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Poses of laser and robot; one pose is that of both, and none is nowhere."""
    x, y, heading, *robot = values or NOWHERE
    laser = (x, y, heading)
    return laser, (robot[0], robot[1], robot[2]) if robot else laser


def _count(fields: list[bytes], place: int) -> int:
    try:
        count = int(fields[place])
    except (ValueError, IndexError):
        count = -1
    if count < 0:
        raise BadLine(f"{fields[0].decode()} does not say how many readings it has")
    return count


def _are_numbers(fields: list[bytes]) -> bool:
    """Whether there is no host among them."""
    try:
        return all(math.isfinite(float(field)) for field in fields)
    except ValueError:
        return False


def _numbers(fields: list[bytes], first: int, beyond: int) -> list[float]:
    """Numbers of a sane size from fields[first:beyond]."""
    try:
        values = [float(field) for field in fields[first:beyond]]
    except ValueError:
        values = [math.nan]
    if not all(abs(value) < _SANE for value in values):
        raise BadLine(f"{fields[0].decode()} has a pose or stamp that is not a number")
    return values
