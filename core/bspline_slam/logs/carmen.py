"""CARMEN text logs: one message per line, laser readings together with the odometry they were taken at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.logs.carmen_index import CarmenIndex, Entry
from bspline_slam.logs.carmen_line import LASERS, SAYS_ANGLES, LaserLine
from bspline_slam.logs.field_of_view import bearings_of_count, count_is_known
from bspline_slam.logs.indexed_log import IndexedLog, Progress
from bspline_slam.logs.peculiarities import beam_notes, moving_or_none, time_notes
from bspline_slam.logs.range_limit import range_limit
from bspline_slam.scan import LaserScan, Records, increasing_times, interpolate_poses

RANGE_MIN = 0.05
"""Readings nearer than this are the sensor's own error values or its own robot (m)."""

_SETTLED = 0.05  # an offset between laser and robot that varies by less is a mounting (m, rad)
_REACH = 3.0  # and no laser stands farther from the middle of its robot (m)
_APART = 0.5  # ODOM lines farther than this from the odometry of the scans around them are another path (m)


@dataclass(frozen=True, eq=False, slots=True)
class Sensor:
    """What holds for all scans of a log: range limit (m) and where the laser stands on the robot."""

    range_max: float
    pose_robot_sensor: Float[np.ndarray, "3"]

    def scan(self, index: int, stamp: float, line: LaserLine) -> LaserScan:
        """The scan that a line holds, its beams in increasing order of bearing."""
        ranges, bearings = line.readings, bearings_of_count(len(line.readings))
        if line.start_angle is not None and line.step is not None:
            bearings = line.start_angle + line.step * np.arange(len(ranges))
        if len(bearings) > 1 and bearings[1] < bearings[0]:
            ranges, bearings = ranges[::-1], bearings[::-1]
        return LaserScan(index, stamp, ranges, bearings, RANGE_MIN, self.range_max, self.pose_robot_sensor)


def read_carmen(path: Path, text: bytes, content_hash: str, topic: str | None, progress: Progress) -> IndexedLog:
    """Index the text of a CARMEN log; `topic` may name another laser of it, such as RLASER.

    LogError when no scan can be read from it.
    """
    found = CarmenIndex.from_text(text, progress)
    tag = _laser(path, found, topic)
    scans = [entry for entry in found.entries if entry.tag == tag]
    kept = [entry for entry in found.entries if entry.tag in (tag, b"ODOM")]
    stamps = np.array([entry.stamp for entry in kept])
    held = np.array([entry.tag == tag for entry in kept])
    times = increasing_times(stamps)
    poses, pose_notes = _odometry(kept, held, times)
    odometry, odometry_notes = moving_or_none(poses)
    mounting, mounting_notes = _mounting(tag, scans, found)
    range_max, range_notes = _range_max(tag, found)
    sensor = Sensor(range_max, mounting)

    def read_scan(index: int) -> LaserScan:
        entry = scans[index]
        assert entry.line is not None
        return sensor.scan(index, entry.stamp, entry.line)

    return IndexedLog.from_records(
        path=path,
        records=Records(stamps, times, odometry, np.where(held, np.cumsum(held) - 1, -1)),
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


# -- which laser -----------------------------------------------------------------------------------------------
def _laser(path: Path, found: CarmenIndex, topic: str | None) -> bytes:
    """The tag asked for, else the first of LASERS that the log has."""
    present = [tag for tag in LASERS if found.beams[tag]]
    if not present:
        raise _no_scan(path, found)
    if topic is None:
        return present[0]
    chosen = next((tag for tag in present if tag.decode() == topic), None)
    if chosen is None:
        names = ", ".join(tag.decode() for tag in present)
        raise LogError(path, f"the log has no laser topic {topic}: its lasers are {names}")
    return chosen


def _no_scan(path: Path, found: CarmenIndex) -> LogError:
    """Why no scan could be read."""
    lasers = tuple(tag.decode() for tag in LASERS)
    damaged = [(number, rule) for number, rule in found.damaged if rule.startswith(lasers)]
    if damaged:
        number, rule = damaged[0]
        return LogError(path, f"{rule}, and no other line holds a scan", number)
    if found.entries or found.parameters or found.damaged:
        return LogError(path, f"the log holds no laser scan: no line begins with {', '.join(lasers)}")
    return LogError(path, f"this is not a laser log: no line begins with {lasers[0]} or another word of CARMEN logs")


# -- poses -----------------------------------------------------------------------------------------------------
def _odometry(
    kept: Sequence[Entry], held: Bool[np.ndarray, "records"], times: Float[np.ndarray, "records"]
) -> tuple[Float[np.ndarray, "records 3"], list[str]]:
    """Odometry of all records; `held` are those that hold a scan.

    Logs went through many hands: where the scans' odometry is zero throughout, ODOM lines or the laser poses carry it,
    and where the scans' odometry was replaced by a corrected path, the ODOM lines no longer belong to it.
    """
    poses = np.array([entry.pose for entry in kept])
    if not poses[held].any():
        if poses[~held].any():
            note = "The odometry poses of the scans are all zero: they are interpolated from the ODOM lines."
            return interpolate_poses(times[~held], poses[~held], times), [note]
        laser = np.array([entry.laser for entry in kept if entry.laser is not None])
        if np.ptp(laser, axis=0).any():
            note = "The odometry poses are all zero: the laser poses are taken as odometry."
            return interpolate_poses(times[held], laser, times), [note]
    elif not held.all() and _leaves_scans(poses, held, times):
        note = "The ODOM lines tell of another path than the odometry of the scans: they are left out."
        return interpolate_poses(times[held], poses[held], times), [note]
    return poses, []


def _leaves_scans(
    poses: Float[np.ndarray, "records 3"], held: Bool[np.ndarray, "records"], times: Float[np.ndarray, "records"]
) -> bool:
    """Whether the records between scans mostly lie farther from the scans' path than one step of that path."""
    between = ~held & (times > times[held][0]) & (times < times[held][-1])
    if not between.any():
        return False
    steps = np.linalg.norm(np.diff(poses[held, :2], axis=0), axis=1)
    path = interpolate_poses(times[held], poses[held], times[between])
    apart = np.linalg.norm(poses[between, :2] - path[:, :2], axis=1)
    return bool(np.median(apart) > _APART + steps.max())


def _mounting(tag: bytes, scans: Sequence[Entry], found: CarmenIndex) -> tuple[Float[np.ndarray, "3"], list[str]]:
    """pose_robot_sensor: the constant offset between laser pose and odometry pose, else what PARAM lines say."""
    robot = np.array([entry.pose for entry in scans])
    offsets = se2.between(robot, np.array([entry.laser for entry in scans]))
    middle = np.median(offsets, axis=0)
    middle[2] = np.arctan2(np.sin(offsets[:, 2]).sum(), np.cos(offsets[:, 2]).sum())
    apart = np.abs(se2.between(middle, offsets)).max(axis=1)
    settled = np.mean(apart < _SETTLED) >= 0.9 and np.hypot(middle[0], middle[1]) < _REACH
    if settled and np.abs(middle).max() > 1e-6:
        return middle, []
    side = "rear" if tag == b"RLASER" else "front"
    names = (f"robot_{side}laser_{what}" for what in ("offset", "side_offset", "angular_offset"))
    announced = np.array([found.parameter(name) or 0.0 for name in names])
    notes = []
    if not settled and robot.any():
        notes.append("The laser poses do not follow the odometry poses (a corrected log?): they are left out.")
    if tag == b"RLASER":
        announced[2] += np.pi
        notes.append("The rear laser is taken to look straight back, as its poses do not say where it looks.")
    if announced[:2].any():
        x, y = announced[:2]
        notes.append(f"The laser stands at x = {x:g} m, y = {y:g} m on the robot by the log's PARAM lines.")
    return announced, notes


def _truth(entries: Sequence[Entry]) -> Float[np.ndarray, "scans 3"] | None:
    """True poses at the scans, interpolated between TRUEPOS lines; None without such lines."""
    true = np.array([entry.tag == b"TRUEPOS" for entry in entries])
    if not true.any():
        return None
    times = increasing_times(np.array([entry.stamp for entry in entries]))
    poses = np.array([entry.pose for entry in entries])
    return interpolate_poses(times[true], poses[true], times[~true])


# -- readings and sentences ------------------------------------------------------------------------------------
def _range_max(tag: bytes, found: CarmenIndex) -> tuple[float, list[str]]:
    """The no-return limit (m): see `range_limit`."""
    side = "rear" if tag == b"RLASER" else "front"
    announced = found.samples[tag][0].max_range or found.parameter(f"robot_{side}_laser_max")
    limit = range_limit([line.readings for line in found.samples[tag]], announced)
    if announced == limit:
        return limit, []
    return limit, [f"Readings of {limit:g} m and more count as beams without return."]


def _line_notes(tag: bytes, found: CarmenIndex) -> list[str]:
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
        notes.append(f"{found.unmeasured[tag]} readings are negative or not a number and count as no measurement.")
    guessed = [count for count in sorted(found.beams[tag]) if tag not in SAYS_ANGLES and not count_is_known(count)]
    if guessed:
        counts = " or ".join(map(str, guessed))
        notes.append(f"No sensor with {counts} beams is known: they are taken to cover 180°.")
    return notes


def _damage_note(found: CarmenIndex) -> str:
    number, rule = found.damaged[0]
    count = len(found.damaged)
    if count == 1 and number == found.lines:
        return f"The last line ({number}) is cut off and left out: {rule}."
    if count == 1:
        return f"Line {number} is left out: {rule}."
    more = ", ".join(str(line) for line, _ in found.damaged[:8]) + (", …" if count > 8 else "")
    return f"{count} lines are left out ({more}); the first, line {number}: {rule}."
