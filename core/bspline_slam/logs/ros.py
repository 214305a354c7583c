"""Laser logs from ROS 1 and ROS 2 recordings: LaserScan messages, with odometry from Odometry messages or TF."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.errors import LogError
from bspline_slam.logs.indexed_log import IndexedLog
from bspline_slam.logs.messages import LASER_SCAN, ODOMETRY, RawMessage, Recording
from bspline_slam.logs.payloads import Payloads
from bspline_slam.logs.peculiarities import beam_notes, moving_or_none, time_notes
from bspline_slam.logs.transforms import FrameTree, in_space, planar, planar_mounting, planar_path, rotation_of
from bspline_slam.scan import LaserScan, Records, increasing_times, interpolate_poses


@dataclass(frozen=True, slots=True)
class Sweep:
    """A LaserScan message: stamp (s), frame, number of beams, unusable readings, and where its payload lies."""

    stamp: float
    recorded: float
    frame: str
    beams: int
    unmeasured: int
    place: tuple[int, int]


@dataclass(frozen=True, eq=False, slots=True)
class Path2D:
    """Poses over time in the order of recording: `times` increase; `base` is the frame that moves ("" if unsaid)."""

    source: str
    base: str
    stamps: Float[np.ndarray, "n"]
    times: Float[np.ndarray, "n"]
    poses: Float[np.ndarray, "n 3"]

    @classmethod
    def from_samples(cls, source: str, base: str, samples: Sequence[tuple[float, Float[np.ndarray, "3"]]]) -> Path2D:
        """A path from (stamp, pose) in the order of recording."""
        stamps = np.array([stamp for stamp, _ in samples])
        return cls(source, base, stamps, increasing_times(stamps), np.array([pose for _, pose in samples]))

    def at(self, times: Float[np.ndarray, "m"]) -> Float[np.ndarray, "m 3"]:
        """Poses at other times, held constant beyond the ends."""
        return np.array([interpolate_poses(self.times, self.poses, float(time)) for time in times])


@dataclass(eq=False, slots=True)
class Gathered:
    """What the index pass gathers on its way through the messages."""

    payloads: Payloads = field(default_factory=Payloads)
    sweeps: dict[str, list[Sweep]] = field(default_factory=lambda: defaultdict(list))
    odometry: dict[str, list[tuple[float, Float[np.ndarray, "3"]]]] = field(default_factory=lambda: defaultdict(list))
    bases: dict[str, str] = field(default_factory=dict)
    frames: FrameTree = field(default_factory=FrameTree)
    damaged: Counter[str] = field(default_factory=Counter)
    first_rule: dict[str, str] = field(default_factory=dict)


class BadMessage(Exception):
    """A message breaks the rule that is its text."""


def read_ros(path: Path, recording: Recording, content_hash: str, topic: str | None) -> IndexedLog:
    """Index a recording. LogError when it has no usable scan, or not the topic asked for."""
    found = gather(recording)
    laser = _laser_topic(path, found, recording, topic)
    sweeps = found.sweeps[laser]
    stamps, stamp_notes = _stamps(sweeps)
    times = increasing_times(stamps)
    odometry, odometry_notes = _odometry(found, sweeps[0].frame, times)
    mounting, upside_down, mounting_notes = _mounting(found.frames, sweeps[0].frame, odometry)
    truth = next((_path(found, name) for name in sorted(found.odometry) if _is_truth(name)), None)
    payloads, decode = found.payloads, recording.decode

    def read_scan(index: int) -> LaserScan:
        message = decode(payloads.read(sweeps[index].place), LASER_SCAN)
        return scan_of(index, float(stamps[index]), message, mounting, upside_down)

    return IndexedLog.from_records(
        path=path,
        records=_records(stamps, times, odometry),
        truth=None if truth is None else truth.at(times),
        notes=(
            *recording.notes,
            *_topic_notes(found, laser, topic),
            *_damage_notes(found),
            *beam_notes(Counter(sweep.beams for sweep in sweeps)),
            *_reading_notes(sweeps),
            *stamp_notes,
            *time_notes(stamps),
            *odometry_notes,
            *mounting_notes,
        ),
        content_hash=content_hash,
        read_scan=read_scan,
    )


def scan_of(
    index: int, stamp: float, message: Any, pose_robot_sensor: Float[np.ndarray, "3"], upside_down: bool
) -> LaserScan:
    """The scan in a LaserScan message, its beams in increasing order of bearing whichever way the sensor turns."""
    ranges = np.asarray(message.ranges, dtype=float)
    bearings = message.angle_min + message.angle_increment * np.arange(len(ranges))
    if upside_down:
        bearings = -bearings
    if len(bearings) > 1 and bearings[1] < bearings[0]:
        ranges, bearings = ranges[::-1], bearings[::-1]
    low = message.range_min if np.isfinite(message.range_min) else 0.0
    high = message.range_max if message.range_max > low else float("inf")
    return LaserScan(index, stamp, ranges, bearings, float(low), float(high), pose_robot_sensor)


# -- the index pass --------------------------------------------------------------------------------------------
def gather(recording: Recording) -> Gathered:
    """One pass over all messages: scans are put aside, poses are kept."""
    found = Gathered()
    for message in recording.messages:
        try:
            _take(found, message, recording)
        except BadMessage as rule:
            found.damaged[message.topic] += 1
            found.first_rule.setdefault(message.topic, str(rule))
    found.payloads.flush()
    return found


def _take(found: Gathered, message: RawMessage, recording: Recording) -> None:
    try:
        decoded = recording.decode(message.payload, message.kind)
    except Exception as error:  # the generated decoder raises whatever a damaged payload makes it stumble over
        raise BadMessage(f"its payload is damaged ({type(error).__name__})") from None
    if message.kind == LASER_SCAN:
        _check_sweep(decoded)
        with np.errstate(invalid="ignore"):
            unmeasured = int(np.count_nonzero(np.isnan(decoded.ranges) | (decoded.ranges < 0)))
        place = found.payloads.append(message.payload)
        header = decoded.header
        found.sweeps[message.topic].append(
            Sweep(_seconds(header), message.recorded, header.frame_id, len(decoded.ranges), unmeasured, place)
        )
    elif message.kind == ODOMETRY:
        pose = planar(_in_space(decoded.pose.pose.position, decoded.pose.pose.orientation))
        if not np.isfinite(pose).all():
            raise BadMessage("its pose is not a number")
        found.odometry[message.topic].append((_seconds(decoded.header) or message.recorded, pose))
        found.bases.setdefault(message.topic, decoded.child_frame_id)
    else:
        for edge in decoded.transforms:
            transform = _in_space(edge.transform.translation, edge.transform.rotation)
            stamp = _seconds(edge.header) or message.recorded
            found.frames.add(edge.header.frame_id, edge.child_frame_id, stamp, transform)


def _check_sweep(message: Any) -> None:
    if len(message.ranges) == 0:
        raise BadMessage("it has no readings")
    if not np.isfinite(message.angle_min) or not np.isfinite(message.angle_increment):
        raise BadMessage("its angles are not numbers")
    if message.angle_increment == 0 and len(message.ranges) > 1:
        raise BadMessage("its angle_increment is zero")


def _seconds(header: Any) -> float:
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def _in_space(translation: Any, rotation: Any) -> Float[np.ndarray, "4 4"]:
    turn = rotation_of(rotation.x, rotation.y, rotation.z, rotation.w)
    return in_space((translation.x, translation.y, translation.z), turn)


# -- what follows from it --------------------------------------------------------------------------------------
def _laser_topic(path: Path, found: Gathered, recording: Recording, wanted: str | None) -> str:
    """The topic asked for, else the one with most scans."""
    announced = sorted(name for name, kind in recording.topics.items() if kind == LASER_SCAN)
    if wanted is not None and wanted not in announced:
        exist = f"its laser topics are {', '.join(announced)}" if announced else "it has no laser topic"
        raise LogError(path, f"the log has no laser topic {wanted}: {exist}")
    candidates = [wanted] if wanted is not None else announced
    usable = [name for name in candidates if found.sweeps.get(name)]
    if usable:
        return max(usable, key=lambda name: len(found.sweeps[name]))
    broken = next((name for name in candidates if found.first_rule.get(name)), None)
    if broken is not None:
        count = found.damaged[broken]
        raise LogError(path, f"none of the {count} scans on {broken} can be used: {found.first_rule[broken]}")
    if announced:
        raise LogError(path, f"the log has no scan on {' or '.join(candidates)}")
    kinds = ", ".join(sorted(set(recording.topics.values()))[:6]) or "no topic at all"
    raise LogError(path, f"the log holds no sensor_msgs/LaserScan, only {kinds}")


def _stamps(sweeps: Sequence[Sweep]) -> tuple[Float[np.ndarray, "scans"], list[str]]:
    stamps = np.array([sweep.stamp for sweep in sweeps])
    if len(stamps) > 1 and not stamps.any():
        return np.array([sweep.recorded for sweep in sweeps]), [
            "The scans have no stamps: the times of recording serve."
        ]
    return stamps, []


def _is_truth(topic: str) -> bool:
    return "truth" in topic.lower()


def _path(found: Gathered, topic: str) -> Path2D:
    return Path2D.from_samples(topic, found.bases[topic], found.odometry[topic])


def _odometry(found: Gathered, sensor: str, scan_times: Float[np.ndarray, "scans"]) -> tuple[Path2D | None, list[str]]:
    """Odometry messages if there are any (the topic with most), else the moving TF edge below a frame like `odom`."""
    topics = sorted(
        (name for name in found.odometry if not _is_truth(name)), key=lambda name: -len(found.odometry[name])
    )
    notes = []
    if topics:
        path = _path(found, topics[0])
        if len(topics) > 1:
            notes.append(f"Odometry is taken from {topics[0]}; {', '.join(topics[1:])} is left out.")
    elif (moving := found.frames.odometry_edge(sensor)) is not None:
        base, edge = moving
        stamps, poses = planar_path(edge)
        path = Path2D(f"TF {edge.parent} → {base}", base, stamps, increasing_times(stamps), poses)
        notes.append(f"Odometry is taken from the transforms {edge.parent} → {base}.")
    else:
        return None, ["The log has no odometry: poses come from scan matching alone."]
    still, still_notes = moving_or_none(path.poses)
    if still is None:
        return None, still_notes
    inside = np.mean((scan_times >= path.times[0] - 1.0) & (scan_times <= path.times[-1] + 1.0))
    if inside == 0:
        return None, [f"The odometry ({path.source}) and the scans have no time in common: it counts as missing."]
    if inside < 0.99:
        notes.append(f"The odometry ({path.source}) covers only {inside:.0%} of the scans; it is held constant beyond.")
    return path, notes


def _mounting(
    frames: FrameTree, sensor: str, odometry: Path2D | None
) -> tuple[Float[np.ndarray, "3"], bool, list[str]]:
    """pose_robot_sensor, whether the sensor hangs upside down, and what was assumed."""
    notes = []
    base = odometry.base if odometry is not None and odometry.base else frames.base_of(sensor)
    transform = frames.mounting(sensor, base)
    if transform is None:
        notes.append(f"No transform joins {sensor} and {base}: the laser is taken to stand at the robot's centre.")
        transform = np.eye(4)
    pose, upside_down = planar_mounting(transform)
    if upside_down:
        notes.append("The laser hangs upside down: its beams are turned over.")
    return pose, upside_down, notes


def _records(stamps: Float[np.ndarray, "scans"], times: Float[np.ndarray, "scans"], odometry: Path2D | None) -> Records:
    """Scans and odometry messages merged on their increasing axes; a scan gets the odometry interpolated to it."""
    if odometry is None:
        return Records(stamps, times, None, np.arange(len(stamps)))
    order = np.argsort(np.concatenate([odometry.times, times]), kind="stable")
    merged = np.concatenate([odometry.times, times])[order]
    poses = np.concatenate([odometry.poses, odometry.at(times)])[order]
    numbers = np.concatenate([np.full(len(odometry.times), -1), np.arange(len(times))])[order]
    return Records(np.concatenate([odometry.stamps, stamps])[order], increasing_times(merged), poses, numbers)


def _topic_notes(found: Gathered, laser: str, wanted: str | None) -> list[str]:
    others = [f"{name} ({len(sweeps)})" for name, sweeps in sorted(found.sweeps.items()) if name != laser and sweeps]
    if not others:
        return []
    choice = "was asked for" if wanted is not None else "has most scans"
    return [f"Scans are read from {laser} ({len(found.sweeps[laser])}), which {choice}; left out: {', '.join(others)}."]


def _damage_notes(found: Gathered) -> list[str]:
    return [
        f"{count} messages on {topic} are left out; of the first: {found.first_rule[topic]}."
        for topic, count in sorted(found.damaged.items())
    ]


def _reading_notes(sweeps: Sequence[Sweep]) -> list[str]:
    unmeasured = sum(sweep.unmeasured for sweep in sweeps)
    return [f"{unmeasured} readings are negative or not a number and count as no measurement."] if unmeasured else []
