"""Messages of a ROS recording as they come out of its file, before anything is decoded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

LASER_SCAN = "sensor_msgs/msg/LaserScan"
MULTI_ECHO = "sensor_msgs/msg/MultiEchoLaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
LASERS = (LASER_SCAN, MULTI_ECHO)
WANTED = (*LASERS, ODOMETRY, TRANSFORMS)

_SAME_LAYOUT = {"tf/msg/tfMessage": TRANSFORMS}


class RawMessage(NamedTuple):
    """One message: its topic, its type (one of WANTED), when it was recorded (s), and its bytes."""

    topic: str
    kind: str
    recorded: float
    payload: bytes


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """What a reader of bags hands over.

    `messages` yields those of the types WANTED in the order of recording; while it runs, `topics` (topic → type, all
    types) and `notes` fill. `decode` turns a payload of a type into rosbags' message object.
    """

    messages: Iterator[RawMessage]
    topics: dict[str, str]
    decode: Callable[[bytes, str], Any]
    notes: list[str] = field(default_factory=list)


def canonical_type(name: str) -> str:
    """`sensor_msgs/LaserScan` and `sensor_msgs/msg/LaserScan` are one; the old tf message is laid out like the new."""
    parts = printable(name).split("/")
    full = "/".join([parts[0], "msg", parts[1]] if len(parts) == 2 else parts)
    return _SAME_LAYOUT.get(full, full)


def printable(name: str) -> str:
    """A name as it may stand in a sentence, whatever a damaged file made of it."""
    return "".join(character if character.isprintable() else "?" for character in name)
