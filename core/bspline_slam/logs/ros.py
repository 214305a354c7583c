"""Laser logs from ROS 1 and ROS 2 recordings: LaserScan or MultiEchoLaserScan messages, with odometry from Odometry
messages or TF."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam.errors import LogError
from bspline_slam.logs.indexed_log import IndexedLog
from bspline_slam.logs.messages import LASERS, Recording
from bspline_slam.logs.peculiarities import beam_notes, moving_or_none, time_notes
from bspline_slam.logs.pose_path import PosePath
from bspline_slam.logs.ros_index import RosIndex, Sweep, scan_of, stamps_or_recorded
from bspline_slam.logs.transforms import FrameTree, frame_name, planar_mounting
from bspline_slam.scan import LaserScan, Records, increasing_times


def read_ros(path: Path, recording: Recording, content_hash: str, topic: str | None) -> IndexedLog:
    """Index a recording. LogError when it has no usable scan, or not the topic asked for."""
    found = RosIndex.from_recording(recording)
    laser = _laser_topic(path, found, recording, topic)
    sweeps = found.sweeps[laser]
    stamps = stamps_or_recorded([sweep.stamp for sweep in sweeps], [sweep.recorded for sweep in sweeps])
    times = increasing_times(stamps)
    odometry, odometry_notes = _odometry(found, sweeps[0].frame, times)
    mounting, upside_down, mounting_notes = _mounting(found.frames, sweeps[0].frame, odometry)
    truth = next((samples for name, samples in sorted(found.odometry.items()) if _is_truth(name)), None)
    payloads, decode, kind = found.payloads, recording.decode, recording.topics[laser]

    def read_scan(index: int) -> LaserScan:
        message = decode(payloads.read(sweeps[index].place), kind)
        return scan_of(index, float(stamps[index]), message, mounting, upside_down)

    return IndexedLog.from_records(
        path=path,
        records=_records(stamps, times, odometry),
        truth=None if truth is None else PosePath.from_messages("truth", truth).at(times),
        notes=(
            *recording.notes,
            *_topic_notes(found, laser, topic),
            *_damage_notes(found),
            *beam_notes(Counter(sweep.beams for sweep in sweeps)),
            *_reading_notes(sweeps),
            *time_notes(stamps, "scans"),
            *odometry_notes,
            *mounting_notes,
        ),
        content_hash=content_hash,
        read_scan=read_scan,
    )


# -- what follows from it --------------------------------------------------------------------------------------
def _laser_topic(path: Path, found: RosIndex, recording: Recording, wanted: str | None) -> str:
    """The topic asked for, else the one with most scans."""
    announced = sorted(name for name, kind in recording.topics.items() if kind in LASERS)
    if wanted is not None and wanted not in announced:
        exist = f"its laser topics are {', '.join(announced)}" if announced else "it has no laser topic"
        raise LogError(path, f"the log has no laser topic {wanted}: {exist}")
    candidates = [wanted] if wanted is not None else announced
    usable = [name for name in candidates if found.sweeps.get(name)]
    if usable:
        return max(usable, key=lambda name: len(found.sweeps[name]))
    broken = next((name for name in candidates if found.rules.get(name)), None)
    if broken is not None:
        count = found.damaged[broken]
        raise LogError(path, f"none of the {count} scans on {broken} can be used: {found.rules[broken]}")
    if announced:
        raise LogError(path, f"the log has no scan on {' or '.join(candidates)}")
    kinds = sorted(set(recording.topics.values()))
    only = f"only {', '.join(kinds[:6])}" if kinds else "and no other topic either"
    raise LogError(path, ". ".join([f"the log holds no sensor_msgs/LaserScan, {only}", *recording.notes]))


def _is_truth(topic: str) -> bool:
    return "truth" in topic.lower()


def _odometry(
    found: RosIndex, sensor: str, scan_times: Float[np.ndarray, "scans"]
) -> tuple[PosePath | None, list[str]]:
    """Odometry messages if there are any (the topic with most), else the moving TF edge below a frame like `odom`."""
    topics = sorted(
        (name for name in found.odometry if not _is_truth(name)), key=lambda name: -len(found.odometry[name])
    )
    notes = []
    if topics:
        path = PosePath.from_messages(topics[0], found.odometry[topics[0]])
        if len(topics) > 1:
            notes.append(f"Odometry is taken from {topics[0]}; {', '.join(topics[1:])} is left out.")
    elif (moving := found.frames.odometry_edge(sensor)) is not None:
        path = PosePath.from_edge(*moving)
        notes.append(f"Odometry is taken from {path.source}.")
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
    frames: FrameTree, sensor: str, odometry: PosePath | None
) -> tuple[Float[np.ndarray, "3"], bool, list[str]]:
    """pose_robot_sensor, whether the sensor hangs upside down, and what was assumed."""
    notes = []
    own = frames.base_of(sensor)
    base = odometry.base if odometry is not None and odometry.base else own
    if not frames.joins(sensor, base):
        where = "at the robot's centre" if own == frame_name(sensor) else f"on the robot as it stands on {own}"
        notes.append(f"No transform joins {sensor} and {base}: the laser is taken to stand {where}.")
        base = own
    pose, upside_down = planar_mounting(frames.mounting(sensor, base))
    if upside_down:
        notes.append("The laser hangs upside down: its beams are turned over.")
    return pose, upside_down, notes


def _records(
    stamps: Float[np.ndarray, "scans"], times: Float[np.ndarray, "scans"], odometry: PosePath | None
) -> Records:
    """Scans and odometry messages merged on their increasing axes; a scan gets the odometry interpolated to it.

    An odometry message with the stamp of a scan is one record with it.
    """
    if odometry is None:
        return Records(stamps, times, None, np.arange(len(stamps)))
    alone = ~np.isin(odometry.stamps, stamps)
    merged = np.concatenate([odometry.times[alone], times])
    order = np.argsort(merged, kind="stable")
    poses = np.concatenate([odometry.poses[alone], odometry.at(times)])
    scan_of_record = np.concatenate([np.full(np.count_nonzero(alone), -1), np.arange(len(times))])
    return Records(
        np.concatenate([odometry.stamps[alone], stamps])[order],
        increasing_times(merged[order]),
        poses[order],
        scan_of_record[order],
    )


def _topic_notes(found: RosIndex, laser: str, wanted: str | None) -> list[str]:
    others = [f"{name} ({len(sweeps)})" for name, sweeps in sorted(found.sweeps.items()) if name != laser and sweeps]
    if not others:
        return []
    choice = "was asked for" if wanted is not None else "has most scans"
    return [f"Scans are read from {laser} ({len(found.sweeps[laser])}), which {choice}; left out: {', '.join(others)}."]


def _damage_notes(found: RosIndex) -> list[str]:
    return [
        f"{count} messages on {topic} are left out; of the first: {found.rules[topic]}."
        for topic, count in sorted(found.damaged.items())
    ]


def _reading_notes(sweeps: Sequence[Sweep]) -> list[str]:
    notes = []
    if not any(sweep.stamp for sweep in sweeps):
        notes.append("The scans have no stamps: the times of recording serve.")
    if (unmeasured := sum(sweep.unmeasured for sweep in sweeps)) > 0:
        notes.append(f"{unmeasured} readings are negative or not a number and count as no measurement.")
    return notes
