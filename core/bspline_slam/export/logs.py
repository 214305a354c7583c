"""Logs out: any ScanLog as CARMEN text or as a ROS 2 bag (MCAP), and its truth in the TUM format."""

from __future__ import annotations

import gzip
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bspline_slam import se2
from bspline_slam.errors import LogError
from bspline_slam.scan import LaserScan, ScanLog

NO_RETURN = 81.83
"""The range (m) that CARMEN logs of SICK lasers hold where nothing came back."""
HALF_CIRCLE_BEAMS = (180, 181, 360, 361)
"""Beam counts from which every CARMEN reader knows the bearings of an FLASER line: a half circle at 1° or 0.5°."""


def write_carmen(log: ScanLog, path: Path) -> None:
    """CARMEN text, gzipped when the name ends in .gz: PARAM lines, then FLASER and ODOM in the order of recording.

    A laser that an FLASER line cannot describe (another field of view or beam count) is written as ROBOTLASER1.
    """
    text = "\n".join(_carmen_lines(log)) + "\n"
    data = text.encode("ascii")
    path.write_bytes(gzip.compress(data, mtime=0) if path.suffix == ".gz" else data)


def _carmen_lines(log: ScanLog) -> Iterator[str]:
    if len(log) == 0:
        raise LogError(log.path, "has no scans to write")
    first = log[0]
    offset, _, turn = first.pose_robot_sensor
    yield "# CARMEN log: PARAM name value; FLASER n r[n] laser_x laser_y laser_theta odom_x odom_y odom_theta times"
    yield f"PARAM robot_frontlaser_offset {offset:g}"
    yield f"PARAM robot_frontlaser_angular_offset {turn:g}"
    yield f"PARAM robot_front_laser_max {first.range_max:g}"
    stamps, rows, odometry = log.records.stamps, log.records.scan_of_record, log.records.odometry
    for i in range(len(stamps)):
        pose = np.zeros(3) if odometry is None else odometry[i]
        clock = f"{stamps[i]:.6f} simulated {stamps[i] - stamps[0]:.6f}"
        if rows[i] >= 0:
            yield f"{_carmen_scan(log[int(rows[i])], pose)} {clock}"
        elif odometry is not None:
            yield f"ODOM {_numbers(pose)} 0 0 0 {clock}"


def _carmen_scan(scan: LaserScan, pose_world_robot: Float[np.ndarray, "3"]) -> str:
    """The line of a scan up to its times."""
    sensor = se2.compose(pose_world_robot, scan.pose_robot_sensor)
    seen = np.where(scan.no_return, max(NO_RETURN, scan.range_max), np.nan_to_num(scan.ranges, nan=0.0))
    readings = f"{len(seen)} {' '.join(f'{reading:.6g}' for reading in seen)}"
    if _is_half_circle(scan):
        return f"FLASER {readings} {_numbers(sensor)} {_numbers(pose_world_robot)}"
    start, width = scan.bearings[0], scan.bearings[-1] - scan.bearings[0]
    laser = f"0 {start:.9g} {width:.9g} {scan.resolution:.9g} {scan.range_max:g} 0.01 0"
    return f"ROBOTLASER1 {laser} {readings} 0 {_numbers(sensor)} {_numbers(pose_world_robot)} 0 0 0 0 0"


def _is_half_circle(scan: LaserScan) -> bool:
    count = len(scan.bearings)
    expected = np.radians(1.0 if count < 200 else 0.5) * np.arange(count) - np.pi / 2
    return count in HALF_CIRCLE_BEAMS and np.allclose(scan.bearings, expected, atol=1e-9)


def _numbers(pose: Float[np.ndarray, "3"]) -> str:
    return " ".join(f"{value:.6f}" for value in pose)


def write_mcap(log: ScanLog, path: Path) -> None:
    """A ROS 2 bag as one MCAP file: /scan, /odom, and the place of the laser on the robot in /tf_static."""
    if len(log) == 0:
        raise LogError(log.path, "has no scans to write")
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with _open_bag(bag) as writer:
            for connection, stamp_ns, data in _bag_messages(log, writer):
                writer.write(connection, stamp_ns, data)
        path.write_bytes((bag / "bag.mcap").read_bytes())


def _open_bag(path: Path) -> Writer:
    writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    return writer


def _bag_messages(log: ScanLog, writer: Writer) -> Iterator[tuple[Any, int, bytes | memoryview]]:
    """(connection, stamp in ns, serialised message) of every record, static transform first."""
    make = _Messages()
    records = log.records
    connections = {
        topic: writer.add_connection(topic, kind, typestore=make.store)
        for topic, kind in (
            ("/tf_static", "tf2_msgs/msg/TFMessage"),
            ("/odom", "nav_msgs/msg/Odometry"),
            ("/scan", "sensor_msgs/msg/LaserScan"),
        )
    }

    def message(topic: str, stamp: float, content: Any) -> tuple[Any, int, bytes | memoryview]:
        return connections[topic], _nanoseconds(stamp), make.store.serialize_cdr(content, connections[topic].msgtype)

    yield message("/tf_static", records.stamps[0], make.static_transform(records.stamps[0], log[0].pose_robot_sensor))
    for i, stamp in enumerate(records.stamps):
        if records.odometry is not None:
            yield message("/odom", stamp, make.odometry(stamp, records.odometry[i]))
        if records.scan_of_record[i] >= 0:
            yield message("/scan", stamp, make.scan(stamp, log[int(records.scan_of_record[i])]))


class _Messages:
    """Makes ROS messages: frames odom → base_link → laser."""

    def __init__(self) -> None:
        self.store = get_typestore(Stores.ROS2_HUMBLE)

    def _make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)

    def _header(self, stamp: float, frame: str) -> Any:
        seconds, nanoseconds = divmod(_nanoseconds(stamp), 10**9)
        time = self._make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
        return self._make("std_msgs/msg/Header", stamp=time, frame_id=frame)

    def _vector(self, x: float = 0.0, y: float = 0.0, kind: str = "Vector3") -> Any:
        return self._make(f"geometry_msgs/msg/{kind}", x=float(x), y=float(y), z=0.0)

    def _turn(self, angle: float) -> Any:
        z, w = float(np.sin(angle / 2)), float(np.cos(angle / 2))
        return self._make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=z, w=w)

    def static_transform(self, stamp: float, pose: Float[np.ndarray, "3"]) -> Any:
        transform = self._make(
            "geometry_msgs/msg/Transform", translation=self._vector(*pose[:2]), rotation=self._turn(pose[2])
        )
        stamped = self._make(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(stamp, "base_link"),
            child_frame_id="laser",
            transform=transform,
        )
        return self._make("tf2_msgs/msg/TFMessage", transforms=[stamped])

    def odometry(self, stamp: float, pose: Float[np.ndarray, "3"]) -> Any:
        place = self._make(
            "geometry_msgs/msg/Pose", position=self._vector(*pose[:2], kind="Point"), orientation=self._turn(pose[2])
        )
        rest = self._make("geometry_msgs/msg/Twist", linear=self._vector(), angular=self._vector())
        unknown = np.zeros(36)
        return self._make(
            "nav_msgs/msg/Odometry",
            header=self._header(stamp, "odom"),
            child_frame_id="base_link",
            pose=self._make("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=unknown),
            twist=self._make("geometry_msgs/msg/TwistWithCovariance", twist=rest, covariance=unknown),
        )

    def scan(self, stamp: float, scan: LaserScan) -> Any:
        return self._make(
            "sensor_msgs/msg/LaserScan",
            header=self._header(stamp, "laser"),
            angle_min=float(scan.bearings[0]),
            angle_max=float(scan.bearings[-1]),
            angle_increment=scan.resolution,
            time_increment=0.0,
            scan_time=0.0,
            range_min=scan.range_min,
            range_max=scan.range_max,
            ranges=scan.ranges.astype(np.float32),
            intensities=np.zeros(0, dtype=np.float32),
        )


def _nanoseconds(stamp: float) -> int:
    """Stamps count in whole microseconds, which a float can hold for a clock of this century."""
    return round(stamp * 1e6) * 1000


def write_truth(log: ScanLog, path: Path) -> None:
    """The true pose of each scan as TUM lines `stamp x y z qx qy qz qw`; LogError when the log has no truth."""
    if log.truth is None:
        raise LogError(log.path, "has no true poses to write")
    stamps = log.records.stamps[log.records.scan_of_record >= 0]
    lines = [
        f"{stamp:.6f} {x:.6f} {y:.6f} 0 0 0 {np.sin(angle / 2):.9f} {np.cos(angle / 2):.9f}"
        for stamp, (x, y, angle) in zip(stamps, log.truth, strict=True)
    ]
    path.write_text("\n".join(lines) + "\n", "ascii")


def log_suffix(path: Path) -> str:
    """The suffix that decides the format: `.log.gz` of `office.log.gz`, `.mcap` of `office.mcap`."""
    return ".log.gz" if path.name.endswith(".log.gz") else path.suffix


def truth_path(path: Path) -> Path:
    """Where the truth of a log lies: `office.truth.tum` beside `office.log.gz` and `office.mcap`."""
    return path.with_name(path.name.removesuffix(log_suffix(path)) + ".truth.tum")


WRITERS: dict[str, Callable[[ScanLog, Path], None]] = {
    ".log": write_carmen,
    ".log.gz": write_carmen,
    ".mcap": write_mcap,
}
"""How to write a log, by suffix."""
