"""CARMEN text logs: one message per line, laser readings together with the odometry they were taken at."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.logs.carmen_line import LASERS, POSES, BadLine, LaserLine, parse_laser, parse_pose
from bspline_slam.logs.field_of_view import bearings_of_count, count_is_known
from bspline_slam.logs.indexed_log import IndexedLog, Progress
from bspline_slam.logs.peculiarities import beam_notes, moving_or_none, time_notes
from bspline_slam.logs.range_limit import range_limit
from bspline_slam.scan import LaserScan, Records, increasing_times, interpolate_poses

RANGE_MIN = 0.05
"""Readings nearer than this are the sensor's own error values or its own robot (m)."""

_SAMPLED_SCANS = 400
_SETTLED = 0.05
_REACH = 3.0


@dataclass(frozen=True, slots=True)
class Entry:
    """A line that was understood: its tag, its bytes in the text, its stamp and the poses it carries."""

    tag: bytes
    start: int
    end: int
    stamp: float
    pose: tuple[float, float, float]
    laser: tuple[float, float, float] | None = None


@dataclass(slots=True)
class Findings:
    """What the index pass gathers on its way through the lines."""

    entries: list[Entry] = field(default_factory=list)
    parameters: dict[str, str] = field(default_factory=dict)
    unknown: Counter[str] = field(default_factory=Counter)
    damaged: list[tuple[int, str]] = field(default_factory=list)
    lines: int = 0
    beams: dict[bytes, Counter[int]] = field(default_factory=lambda: {tag: Counter() for tag in LASERS})
    samples: dict[bytes, list[LaserLine]] = field(default_factory=lambda: {tag: [] for tag in LASERS})
    unmeasured: Counter[bytes] = field(default_factory=Counter)


@dataclass(frozen=True, eq=False, slots=True)
class Sensor:
    """What holds for all scans of a log: range limit (m) and where the laser sits on the robot."""

    range_max: float
    pose_robot_sensor: Float[np.ndarray, "3"]

    def scan(self, index: int, line: LaserLine) -> LaserScan:
        """The scan that a line holds, its beams in increasing order of bearing."""
        ranges, bearings = line.readings, bearings_of_count(len(line.readings))
        if line.start_angle is not None and line.step is not None:
            bearings = line.start_angle + line.step * np.arange(len(ranges))
        if len(bearings) > 1 and bearings[1] < bearings[0]:
            ranges, bearings = ranges[::-1], bearings[::-1]
        return LaserScan(index, line.stamp, ranges, bearings, RANGE_MIN, self.range_max, self.pose_robot_sensor)


def read_carmen(path: Path, text: bytes, content_hash: str, topic: str | None, progress: Progress) -> IndexedLog:
    """Index the text of a CARMEN log; `topic` may name another laser of it, such as RLASER.

    LogError when no scan can be read from it.
    """
    found = walk(text, progress)
    tag = _laser(path, found, topic)
    scans = [entry for entry in found.entries if entry.tag == tag]
    kept = [entry for entry in found.entries if entry.tag in (tag, b"ODOM")]
    stamps = np.array([entry.stamp for entry in kept])
    poses, offsets, pose_notes = _poses(kept, scans)
    odometry, odometry_notes = moving_or_none(poses)
    mounting, mounting_notes = _mounting(tag, offsets, found.parameters)
    range_max, range_notes = _range_max(tag, found)
    held = np.array([entry.tag == tag for entry in kept])
    sensor = Sensor(range_max, mounting)

    def read_scan(index: int) -> LaserScan:
        return sensor.scan(index, parse_laser(text[scans[index].start : scans[index].end].split()))

    return IndexedLog.from_records(
        path=path,
        records=Records(stamps, increasing_times(stamps), odometry, np.where(held, np.cumsum(held) - 1, -1)),
        truth=_truth([entry for entry in found.entries if entry.tag in (tag, b"TRUEPOS")]),
        notes=(
            *_line_notes(tag, found),
            *beam_notes(found.beams[tag]),
            *time_notes(stamps),
            *pose_notes,
            *odometry_notes,
            *mounting_notes,
            *range_notes,
        ),
        content_hash=content_hash,
        read_scan=read_scan,
    )


# -- the index pass --------------------------------------------------------------------------------------------
def walk(text: bytes, progress: Progress) -> Findings:
    """One pass over all lines: index those that are understood, count the others."""
    found = Findings()
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")).tolist()
    bounds = [-1, *ends] if text.endswith(b"\n") else [-1, *ends, len(text)]
    found.lines = len(bounds) - 1
    stride = max(found.lines // _SAMPLED_SCANS, 1)
    for number, (before, end) in enumerate(pairwise(bounds), start=1):
        if number % 1000 == 0:
            progress(end / len(text))
        fields = text[before + 1 : end].split()
        if not fields or fields[0].startswith(b"#"):
            continue
        try:
            _index_line(found, fields, before + 1, end, sampled=number % stride == 0)
        except BadLine as rule:
            found.damaged.append((number, str(rule)))
    return found


def _index_line(found: Findings, fields: list[bytes], start: int, end: int, sampled: bool) -> None:
    tag = fields[0]
    if tag in LASERS:
        line = parse_laser(fields)
        found.entries.append(Entry(tag, start, end, line.stamp, line.pose, line.laser))
        found.beams[tag][len(line.readings)] += 1
        found.unmeasured[tag] += len(line.readings) - int(np.count_nonzero(line.readings >= 0))
        if sampled or not found.samples[tag]:
            found.samples[tag].append(line)
    elif tag in POSES:
        pose = parse_pose(fields)
        found.entries.append(Entry(tag, start, end, pose.stamp, pose.pose))
    elif tag == b"PARAM" and len(fields) > 2:
        found.parameters[fields[1].decode("latin-1")] = fields[2].decode("latin-1")
    else:
        found.unknown[tag[:24].decode("latin-1")] += 1


# -- what follows from it --------------------------------------------------------------------------------------
def _laser(path: Path, found: Findings, topic: str | None) -> bytes:
    """The tag asked for, else the first of LASERS that the log has."""
    present = [tag for tag in LASERS if found.beams[tag]]
    if not present:
        raise _no_scan(path, found)
    if topic is None:
        return present[0]
    if topic.encode() not in present:
        names = ", ".join(tag.decode() for tag in present)
        raise LogError(path, f"the log has no laser topic {topic}: its lasers are {names}")
    return topic.encode()


def _no_scan(path: Path, found: Findings) -> LogError:
    """Why no scan could be read."""
    damaged = [(number, rule) for number, rule in found.damaged if rule.split()[0].encode() in LASERS]
    if damaged:
        number, rule = damaged[0]
        return LogError(path, f"{rule}, and no other line holds a scan", number)
    if found.entries or found.parameters:
        return LogError(path, "the log holds no laser scan: no line begins with FLASER, ROBOTLASER1 or RLASER")
    return LogError(path, "this is not a laser log: no line begins with FLASER, ROBOTLASER1, RLASER or ODOM")


def _poses(
    kept: Sequence[Entry], scans: Sequence[Entry]
) -> tuple[Float[np.ndarray, "records 3"], Float[np.ndarray, "scans 3"], list[str]]:
    """Odometry of all records, and where the laser stands on the robot by the two poses of each scan.

    A log whose odometry fields are all zero while its laser poses move carries its odometry in the latter.
    """
    poses = np.array([entry.pose for entry in kept])
    laser = np.array([entry.laser for entry in scans])
    robot = np.array([entry.pose for entry in scans])
    if len(kept) == len(scans) and not robot.any() and np.ptp(laser, axis=0).any():
        return laser, np.zeros_like(laser), ["The odometry poses are all zero: the laser poses are taken as odometry."]
    return poses, se2.between(robot, laser), []


def _mounting(
    tag: bytes, offsets: Float[np.ndarray, "scans 3"], parameters: dict[str, str]
) -> tuple[Float[np.ndarray, "3"], list[str]]:
    """pose_robot_sensor: the constant offset between laser pose and odometry pose, else what PARAM lines say."""
    middle = np.median(offsets, axis=0)
    middle[2] = np.angle(np.exp(1j * offsets[:, 2]).sum()) if np.any(offsets[:, 2]) else 0.0
    apart = se2.between(middle, offsets)
    settled = float(np.mean(np.abs(apart).max(axis=1) < _SETTLED)) >= 0.9 and np.hypot(*middle[:2]) < _REACH
    if settled and np.abs(middle).max() > 1e-6:
        return middle, []
    side = "rear" if tag == b"RLASER" else "front"
    names = (f"robot_{side}laser_{what}" for what in ("offset", "side_offset", "angular_offset"))
    announced = np.array([_number(parameters.get(name)) or 0.0 for name in names])
    notes = (
        [] if settled else ["The laser poses do not follow the odometry poses (a corrected log?): they are ignored."]
    )
    if tag == b"RLASER":
        announced[2] += np.pi
        notes.append("The rear laser is taken to look straight back, as its poses do not say where it looks.")
    if announced[:2].any():
        x, y = announced[:2]
        notes.append(f"The laser stands at x = {x:g} m, y = {y:g} m on the robot by the log's PARAM lines.")
    return announced, notes


def _range_max(tag: bytes, found: Findings) -> tuple[float, list[str]]:
    """The no-return limit (m): see `range_limit`."""
    side = "rear" if tag == b"RLASER" else "front"
    announced = found.samples[tag][0].max_range or _number(found.parameters.get(f"robot_{side}_laser_max"))
    limit = range_limit([line.readings for line in found.samples[tag]], announced)
    if announced == limit:
        return limit, []
    return limit, [f"Readings of {limit:g} m and more count as beams without return."]


def _truth(entries: Sequence[Entry]) -> Float[np.ndarray, "scans 3"] | None:
    """True poses at the scans, interpolated between TRUEPOS lines; None without such lines."""
    true = np.array([entry.tag == b"TRUEPOS" for entry in entries])
    if not true.any():
        return None
    times = increasing_times(np.array([entry.stamp for entry in entries]))
    poses = np.array([entry.pose for entry in entries])
    return np.array([interpolate_poses(times[true], poses[true], float(time)) for time in times[~true]])


def _line_notes(tag: bytes, found: Findings) -> list[str]:
    notes = []
    if not found.beams[b"FLASER"]:
        notes.append(f"The log has no FLASER lines: its scans are read from {tag.decode()} lines.")
    others = [(other.decode(), found.beams[other].total()) for other in LASERS if other != tag and found.beams[other]]
    notes += [f"{count} {name} lines of another laser are left out." for name, count in others]
    if found.damaged:
        notes.append(_damage_note(found))
    if found.unknown:
        kinds = ", ".join(f"{name} ({count})" for name, count in found.unknown.most_common(5))
        notes.append(f"{found.unknown.total()} lines of unknown kind are left out: {kinds}.")
    if found.unmeasured[tag]:
        notes.append(f"{found.unmeasured[tag]} readings are negative or not finite and count as no measurement.")
    guessed = [count for count in sorted(found.beams[tag]) if tag != b"ROBOTLASER1" and not count_is_known(count)]
    if guessed:
        counts = " or ".join(map(str, guessed))
        notes.append(f"No sensor with {counts} beams is known: they are taken to cover 180°.")
    return notes


def _damage_note(found: Findings) -> str:
    number, rule = found.damaged[0]
    count = len(found.damaged)
    if count == 1 and number == found.lines:
        return f"The last line ({number}) is cut off and left out: {rule}."
    if count == 1:
        return f"Line {number} is left out: {rule}."
    more = ", ".join(str(line) for line, _ in found.damaged[:8]) + (", …" if count > 8 else "")
    return f"{count} lines are left out ({more}); the first, line {number}: {rule}."


def _number(text: str | None) -> float | None:
    try:
        value = float(text) if text is not None else None
    except ValueError:
        return None
    return value if value is not None and np.isfinite(value) else None
