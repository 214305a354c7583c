"""The tree of frames that a ROS log publishes, reduced to the plane."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

_STILL = 1e-6
_BASES = ("base_footprint", "base_link")


def rotation_of(x: float, y: float, z: float, w: float) -> Float[np.ndarray, "3 3"]:
    """Rotation matrix of a quaternion of any length; the identity for (0, 0, 0, 0)."""
    norm = x * x + y * y + z * z + w * w
    if norm == 0:
        return np.eye(3)
    s = 2.0 / norm
    return np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ]
    )


def planar(transform: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "3"]:
    """(x, y, heading of the x axis) of a transform in space."""
    return np.array([transform[0, 3], transform[1, 3], np.arctan2(transform[1, 0], transform[0, 0])])


def in_space(translation: tuple[float, float, float], rotation: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "4 4"]:
    """Homogeneous transform."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, translation
    return out


@dataclass(eq=False, slots=True)
class Edge:
    """Where a frame stands in its parent, as often as it was published; stamps and times of recording in seconds."""

    parent: str
    stamps: list[float] = field(default_factory=list)
    recorded: list[float] = field(default_factory=list)
    transforms: list[Float[np.ndarray, "4 4"]] = field(default_factory=list)

    @property
    def moves(self) -> bool:
        """Whether the transform ever changed."""
        first = self.transforms[0]
        return any(np.abs(other - first).max() > _STILL for other in self.transforms[1:])


@dataclass(frozen=True, eq=False, slots=True)
class FrameTree:
    """Frames by name, each with the edge to its parent."""

    edges: dict[str, Edge] = field(default_factory=dict)

    def add(self, parent: str, child: str, stamp: float, recorded: float, transform: Float[np.ndarray, "4 4"]) -> None:
        """Take in one published transform; a frame keeps the first parent it was given."""
        parent, child = frame_name(parent), frame_name(child)
        edge = self.edges.setdefault(child, Edge(parent))
        if edge.parent == parent:
            edge.stamps.append(stamp)
            edge.recorded.append(recorded)
            edge.transforms.append(transform)

    def above(self, frame: str) -> list[str]:
        """The frame and its ancestors, nearest first."""
        chain = [frame_name(frame)]
        while (edge := self.edges.get(chain[-1])) is not None and edge.parent not in chain:
            chain.append(edge.parent)
        return chain

    def odometry_edge(self, sensor: str) -> tuple[str, Edge] | None:
        """The robot's frame and its moving edge to a parent named like `odom`: above the sensor if there is one."""
        frames = [*self.above(sensor), *sorted(self.edges)]
        for frame in frames:
            edge = self.edges.get(frame)
            if edge is not None and "odom" in edge.parent.lower() and edge.moves:
                return frame, edge
        return None

    def joins(self, sensor: str, base: str) -> bool:
        """Whether the robot's frame `base` stands above the sensor."""
        return frame_name(base) in self.above(sensor)

    def mounting(self, sensor: str, base: str) -> Float[np.ndarray, "4 4"]:
        """Transform from the sensor to a frame that it joins."""
        chain = self.above(sensor)
        out = np.eye(4)
        for frame in chain[: chain.index(frame_name(base))]:
            out = self.edges[frame].transforms[0] @ out
        return out

    def base_of(self, sensor: str) -> str:
        """The robot's frame when nothing else tells it: a usual name above the sensor, else the topmost still frame."""
        chain = self.above(sensor)
        known = [frame for frame in chain if frame in _BASES]
        if known:
            return known[-1]
        still = 0
        while still < len(chain) - 1 and not self.edges[chain[still]].moves:
            still += 1
        return chain[still]


def frame_name(name: str) -> str:
    """ROS 1 wrote frames with a leading slash."""
    return name.lstrip("/")


def planar_mounting(transform: Float[np.ndarray, "4 4"]) -> tuple[Float[np.ndarray, "3"], bool]:
    """pose_robot_sensor in the plane, and whether the sensor hangs upside down (its bearings then run clockwise)."""
    return planar(transform), bool(transform[2, 2] < 0)
