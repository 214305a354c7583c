"""Logs of every format, written for the tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

LASER_SCAN, MULTI_ECHO = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/MultiEchoLaserScan"
ODOMETRY, TRANSFORMS = "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"


class Carmen:
    """Lines of CARMEN logs."""

    @staticmethod
    def flaser(
        stamp: float,
        pose: Sequence[float] = (0.0, 0.0, 0.0),
        readings: Sequence[float] | None = None,
        laser: Sequence[float] | None = None,
        tag: str = "FLASER",
    ) -> str:
        readings = [2.0 + 0.01 * i for i in range(180)] if readings is None else readings
        numbers = [*readings, *(pose if laser is None else laser), *pose]
        return f"{tag} {len(readings)} {' '.join(f'{n:g}' for n in numbers)} {stamp:.6f} robot {stamp:.6f}"

    @staticmethod
    def robotlaser(
        stamp: float, readings: Sequence[float], start: float, step: float, maximum: float, remissions: int = 0
    ) -> str:
        head = f"ROBOTLASER1 0 {start} {step * (len(readings) - 1)} {step} {maximum} 0.01 {int(remissions > 0)}"
        values = " ".join(f"{n:g}" for n in readings)
        bright = " ".join([str(remissions), *["7"] * remissions])
        return f"{head} {len(readings)} {values} {bright} 1.2 2 0.5 1 2 0.5 0 0 0.4 0.4 100000 {stamp} robot {stamp}"

    @staticmethod
    def odom(stamp: float, pose: Sequence[float]) -> str:
        return f"ODOM {' '.join(f'{n:g}' for n in pose)} 0.1 0 0 {stamp:.6f} robot {stamp:.6f}"

    @staticmethod
    def truepos(stamp: float, pose: Sequence[float]) -> str:
        return f"TRUEPOS {' '.join(f'{n:g}' for n in pose)} 0 0 0 {stamp:.6f} robot {stamp:.6f}"

    def drive(self, count: int = 10) -> list[str]:
        """Scans 0.1 s apart of a robot that drives straight on at 1 m/s."""
        return [self.flaser(10 + 0.1 * i, (0.1 * i, 0.0, 0.0)) for i in range(count)]


@dataclass
class Bag:
    """Messages of a recording in either generation of ROS, to be written as `bag`, `db3` or `mcap`."""

    kind: str
    messages: list[tuple[str, str, float, Any]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.store = get_typestore(Stores.ROS1_NOETIC if self.kind == "bag" else Stores.ROS2_HUMBLE)
        if self.kind == "bag":
            self.store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))

    def make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)

    def header(self, stamp: float, frame: str) -> Any:
        nanoseconds = round(stamp * 1e9)
        time = self.make("builtin_interfaces/msg/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
        sequence = {"seq": 0} if self.kind == "bag" else {}
        return self.make("std_msgs/msg/Header", stamp=time, frame_id=frame, **sequence)

    def vector(self, kind: str, x: float, y: float, z: float = 0.0) -> Any:
        return self.make(f"geometry_msgs/msg/{kind}", x=float(x), y=float(y), z=float(z))

    def turn(self, angle: float, upside_down: bool = False) -> Any:
        half_sine, half_cosine = float(np.sin(angle / 2)), float(np.cos(angle / 2))
        if upside_down:  # Rz(angle) Rx(180°)
            return self.make("geometry_msgs/msg/Quaternion", x=half_cosine, y=half_sine, z=0.0, w=0.0)
        return self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=half_sine, w=half_cosine)

    def scan(
        self,
        stamp: float,
        ranges: Sequence[float] = (1.0, 2.0, 3.0),
        angle_min: float = -0.5,
        angle_increment: float = 0.5,
        topic: str = "/scan",
        recorded: float | None = None,
        range_max: float = 10.0,
    ) -> None:
        message = self.make(
            LASER_SCAN,
            header=self.header(stamp, "laser"),
            angle_min=angle_min,
            angle_max=angle_min + angle_increment * (len(ranges) - 1),
            angle_increment=angle_increment,
            time_increment=0.0,
            scan_time=0.1,
            range_min=0.1,
            range_max=range_max,
            ranges=np.array(ranges, dtype=np.float32),
            intensities=np.array([], dtype=np.float32),
        )
        self.messages.append((topic, LASER_SCAN, stamp if recorded is None else recorded, message))

    def echoes(self, stamp: float, echoes: Sequence[Sequence[float]], topic: str = "/echoes") -> None:
        """A scan of a laser that hears several echoes of each beam."""

        def heard(values: Sequence[float]) -> Any:
            return self.make("sensor_msgs/msg/LaserEcho", echoes=np.array(values, dtype=np.float32))

        message = self.make(
            MULTI_ECHO,
            header=self.header(stamp, "laser"),
            angle_min=-0.5,
            angle_max=-0.5 + 0.5 * (len(echoes) - 1),
            angle_increment=0.5,
            time_increment=0.0,
            scan_time=0.1,
            range_min=0.1,
            range_max=10.0,
            ranges=[heard(values) for values in echoes],
            intensities=[heard(()) for _ in echoes],
        )
        self.messages.append((topic, MULTI_ECHO, stamp, message))

    def odometry(self, stamp: float, pose: Sequence[float], topic: str = "/odom", base: str = "base_link") -> None:
        place = self.make(
            "geometry_msgs/msg/Pose", position=self.vector("Point", pose[0], pose[1]), orientation=self.turn(pose[2])
        )
        still = self.make(
            "geometry_msgs/msg/Twist", linear=self.vector("Vector3", 0, 0), angular=self.vector("Vector3", 0, 0)
        )
        message = self.make(
            ODOMETRY,
            header=self.header(stamp, "odom"),
            child_frame_id=base,
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=np.zeros(36)),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=still, covariance=np.zeros(36)),
        )
        self.messages.append((topic, ODOMETRY, stamp, message))

    def transform(
        self,
        stamp: float,
        parent: str,
        child: str,
        pose: Sequence[float],
        topic: str = "/tf",
        upside_down: bool = False,
    ) -> None:
        edge = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(stamp, parent),
            child_frame_id=child,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self.vector("Vector3", pose[0], pose[1], 0.3),
                rotation=self.turn(pose[2], upside_down),
            ),
        )
        self.messages.append((topic, TRANSFORMS, stamp, self.make(TRANSFORMS, transforms=[edge])))

    def drive(self, count: int = 10) -> None:
        """Scans and odometry 0.1 s apart of a robot that drives straight on at 1 m/s, its laser 0.1 m ahead."""
        self.transform(100.0, "base_link", "laser", (0.1, 0.0, 0.0), topic="/tf_static")
        for i in range(count):
            self.odometry(100 + 0.1 * i, (0.1 * i, 0.0, 0.0))
            self.scan(100 + 0.1 * i, recorded=100.02 + 0.1 * i)

    def write(self, folder: Path, name: str = "drive", prepare: Callable[[Any], None] | None = None) -> Path:
        """The log: a `.bag` file, or a folder with a database or MCAP file."""
        if self.kind == "bag":
            path = folder / f"{name}.bag"
            return self._write(Writer1(path), path, self.store.serialize_ros1, prepare)
        path = folder / name
        plugin = StoragePlugin.SQLITE3 if self.kind == "db3" else StoragePlugin.MCAP
        return self._write(Writer2(path, version=9, storage_plugin=plugin), path, self.store.serialize_cdr, prepare)

    def write_file(self, folder: Path, name: str = "drive") -> Path:
        """The log as a single file."""
        path = self.write(folder, name)
        return path if path.is_file() else path / f"{name}.{self.kind}"

    def _write(self, writer: Any, path: Path, serialize: Any, prepare: Callable[[Any], None] | None) -> Path:
        if prepare is not None:
            prepare(writer)
        with writer:
            connections: dict[str, Any] = {}
            for topic, kind, recorded, message in self.messages:
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self.store)
                payload = message if isinstance(message, bytes) else serialize(message, kind)
                writer.write(connections[topic], round(recorded * 1e9), payload)
        return path


@pytest.fixture
def carmen() -> Carmen:
    return Carmen()


@pytest.fixture
def write_lines(tmp_path: Path) -> Callable[..., Path]:
    """Writes lines of text into a log file."""

    def write(lines: Sequence[str], name: str = "drive.log", end: str = "\n") -> Path:
        path = tmp_path / name
        path.write_text("\n".join(lines) + end)
        return path

    return write


@pytest.fixture(params=["bag", "db3", "mcap"])
def bag(request: pytest.FixtureRequest) -> Bag:
    """An empty recording, once for each format."""
    return Bag(request.param)


@pytest.fixture
def new_bag() -> Callable[[str], Bag]:
    """Makes an empty recording of one format."""
    return Bag
