"""The index pass over a ROS recording: scans are put aside undecoded, poses and transforms are kept."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.logs.messages import LASERS, ODOMETRY, RawMessage, Recording
from bspline_slam.logs.payloads import Payloads
from bspline_slam.logs.transforms import FrameTree, in_space, planar, rotation_of
from bspline_slam.scan import LaserScan

_LEAST_STEP = 1e-6  # rad
_SANE = 1e9  # m
_TURNED = 100.0  # rad: no sensor counts its turns so far, and steps would be lost in rounding


class BadMessage(Exception):
    """A message breaks the rule that is its text."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A message of LASERS: stamps (s), frame, number of beams, unusable readings, and where its payload lies."""

    stamp: float
    recorded: float
    frame: str
    beams: int
    unmeasured: int
    place: tuple[int, int]


@dataclass(frozen=True, eq=False, slots=True)
class OdometrySample:
    """An Odometry message: stamps (s), the planar pose, and the frame that it tells of."""

    stamp: float
    recorded: float
    base: str
    pose: Float[np.ndarray, "3"]


@dataclass(eq=False, slots=True)
class RosIndex:
    """What the pass gathers: per topic the scans and odometry, the tree of frames, and the messages that were damaged.

    `damaged` counts messages by topic, `rules` tells of the first of each topic what is wrong with it.
    """

    payloads: Payloads = field(default_factory=Payloads)
    sweeps: dict[str, list[Sweep]] = field(default_factory=lambda: defaultdict(list))
    odometry: dict[str, list[OdometrySample]] = field(default_factory=lambda: defaultdict(list))
    frames: FrameTree = field(default_factory=FrameTree)
    damaged: Counter[str] = field(default_factory=Counter)
    rules: dict[str, str] = field(default_factory=dict)

    @classmethod
    def from_recording(cls, recording: Recording) -> RosIndex:
        """One pass over all messages."""
        found = cls()
        for message in recording.messages:
            try:
                found.add(message, recording)
            except BadMessage as rule:
                found.damaged[message.topic] += 1
                found.rules.setdefault(message.topic, str(rule))
        found.payloads.flush()
        return found

    def add(self, message: RawMessage, recording: Recording) -> None:
        """Take in one message. BadMessage when it is damaged or its numbers make no sense."""
        try:
            decoded = recording.decode(message.payload, message.kind)
        except Exception as error:  # the generated decoder raises whatever a damaged payload makes it stumble over
            raise BadMessage(f"its payload is damaged ({type(error).__name__})") from None
        if message.kind in LASERS:
            self._add_sweep(message, decoded)
        elif message.kind == ODOMETRY:
            pose = _transform(decoded.pose.pose.position, decoded.pose.pose.orientation)
            sample = OdometrySample(_seconds(decoded.header), message.recorded, decoded.child_frame_id, planar(pose))
            self.odometry[message.topic].append(sample)
        else:
            for edge in decoded.transforms:
                transform = _transform(edge.transform.translation, edge.transform.rotation)
                stamps = _seconds(edge.header), message.recorded
                self.frames.add(edge.header.frame_id, edge.child_frame_id, *stamps, transform)

    def _add_sweep(self, message: RawMessage, decoded: Any) -> None:
        _check_angles(decoded)
        readings = readings_of(decoded)
        with np.errstate(invalid="ignore"):
            unmeasured = int(np.count_nonzero(np.isnan(readings) | (readings < 0)))
        stamps = _seconds(decoded.header), message.recorded
        place = self.payloads.append(message.payload)
        sweep = Sweep(*stamps, decoded.header.frame_id, len(readings), unmeasured, place)
        self.sweeps[message.topic].append(sweep)


def scan_of(
    index: int, stamp: float, message: Any, pose_robot_sensor: Float[np.ndarray, "3"], upside_down: bool
) -> LaserScan:
    """The scan in a message of LASERS, its beams in increasing order of bearing whichever way the sensor turns."""
    ranges = readings_of(message)
    bearings = message.angle_min + message.angle_increment * np.arange(len(ranges))
    if upside_down:
        bearings = -bearings
    if len(bearings) > 1 and bearings[1] < bearings[0]:
        ranges, bearings = ranges[::-1], bearings[::-1]
    low = message.range_min if np.isfinite(message.range_min) else 0.0
    high = message.range_max if message.range_max > low else float("inf")
    return LaserScan(index, stamp, ranges, bearings, float(low), float(high), pose_robot_sensor)


def readings_of(message: Any) -> Float[np.ndarray, "beams"]:
    """The ranges (m) of a message of LASERS: of several echoes the first one, which is the nearest surface; +inf where
    none came back."""
    if len(message.ranges) == 0 or not hasattr(message.ranges[0], "echoes"):
        return np.asarray(message.ranges, dtype=float)
    return np.array([beam.echoes[0] if len(beam.echoes) else np.inf for beam in message.ranges], dtype=float)


def stamps_or_recorded(stamps: Sequence[float], recorded: Sequence[float]) -> Float[np.ndarray, "n"]:
    """The stamps, or the times of recording where a publisher left all stamps at zero."""
    return np.array(stamps if any(stamps) else recorded)


def _check_angles(message: Any) -> None:
    step = abs(message.angle_increment)
    if len(message.ranges) == 0:
        raise BadMessage("it has no readings")
    if not abs(message.angle_min) < _TURNED or not np.isfinite(step):
        raise BadMessage("its angles are not numbers")
    if len(message.ranges) > 1 and not _LEAST_STEP <= step <= np.pi:
        raise BadMessage(f"its angle_increment is {message.angle_increment:g} rad")


def _seconds(header: Any) -> float:
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def _transform(translation: Any, rotation: Any) -> Float[np.ndarray, "4 4"]:
    turn = rotation_of(rotation.x, rotation.y, rotation.z, rotation.w)
    transform = in_space((translation.x, translation.y, translation.z), turn)
    if not np.all(np.abs(transform) < _SANE):
        raise BadMessage("its pose is not a number")
    return transform
