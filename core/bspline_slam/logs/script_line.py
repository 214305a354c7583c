"""One line of a script of the mapper, in which the oldest published logs are (B21 robots, centimetres and degrees).

`@SENS 13-08-97 12:00:01.5` says when; `#ROBOT x y θ` where the robot is by odometry; `#LASER n fov: r₁ … r_n` what its
laser sees. The same with the time in each line: `POS 13-08-97 12:00:01.5: x y θ`, `LASER-RANGE 13-08-97 12:00:01.6 n
fov: r₁ … r_n`. Brackets and commas around numbers count for nothing.
"""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
from jaxtyping import Float

CLOCK = b"@SENS"
SCRIPT_POSES = (b"#ROBOT", b"POS")
SCRIPT_LASERS = (b"#LASER", b"LASER-RANGE")
CENTIMETRE = 0.01

_SANE = 1e12  # centimetres, degrees: whatever is larger is damage


class BadLine(Exception):
    """A line breaks the rule that is its text."""


def clock_of(fields: list[bytes]) -> float | None:
    """Seconds of the date and the time that follow the first word; None where none do. BadLine when they are none."""
    if len(fields) < 3 or fields[1].count(b"-") != 2:
        return None
    date, (clock, _, fraction) = fields[1].decode("latin-1"), fields[2].decode("latin-1").strip(":,").partition(".")
    year = "%Y" if len(date.split("-")[2]) == 4 else "%y"
    try:
        whole = datetime.strptime(f"{date} {clock}", f"%d-%m-{year} %H:%M:%S").replace(tzinfo=UTC)
        return whole.timestamp() + float(f"0.{fraction or 0}")
    except ValueError:
        raise BadLine(f"{fields[0].decode()} has a date or time that is none") from None


def script_pose(fields: list[bytes]) -> tuple[float, float, float]:
    """x, y (m) and heading (rad) of a line of SCRIPT_POSES. BadLine when they are no numbers."""
    values = _numbers(fields[0], _content(fields)[-3:])
    if len(values) != 3:
        raise BadLine(f"{fields[0].decode()} needs x, y and a heading")
    x, y, heading = values.tolist()
    return CENTIMETRE * x, CENTIMETRE * y, float(np.radians(heading))


def script_readings(fields: list[bytes]) -> Float[np.ndarray, "beams"]:
    """Ranges (m) of a line of SCRIPT_LASERS. BadLine when there are not as many as announced."""
    head, colon, rest = b" ".join(_content(fields)).partition(b":")
    readings = _numbers(fields[0], rest.split() if colon else head.split()[1:])
    announced = _numbers(fields[0], head.split()[:1])
    if len(readings) == 0 or len(announced) == 0:
        raise BadLine(f"{fields[0].decode()} announces no readings")
    if announced[0] != len(readings):
        raise BadLine(f"{fields[0].decode()} announces {announced[0]:g} readings, found {len(readings)}")
    return CENTIMETRE * readings


def _content(fields: list[bytes]) -> list[bytes]:
    """What follows the first word and the time."""
    return fields[1:] if clock_of(fields) is None else fields[3:]


def _numbers(word: bytes, fields: list[bytes]) -> Float[np.ndarray, "n"]:
    bare = b" ".join(fields).translate(None, b"()[]").replace(b",", b" ").replace(b":", b" ").split()
    try:
        values = np.array([float(field) for field in bare])
    except ValueError:
        values = np.array([np.inf])
    if not (np.abs(values) < _SANE).all():
        raise BadLine(f"{word.decode('latin-1')} has a value that is not a number")
    return values
