"""A path that ROS messages tell: poses of a frame over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.logs.ros_index import OdometrySample, stamps_or_recorded
from bspline_slam.logs.transforms import Edge, planar
from bspline_slam.scan import increasing_times, interpolate_poses


@dataclass(frozen=True, eq=False, slots=True)
class PosePath:
    """Planar poses in the order of recording: where they come from, the frame that moves ("" if unsaid), `stamps` as
    published and the increasing `times` made from them (s)."""

    source: str
    base: str
    stamps: Float[np.ndarray, "n"]
    times: Float[np.ndarray, "n"]
    poses: Float[np.ndarray, "n 3"]

    @classmethod
    def from_messages(cls, topic: str, samples: Sequence[OdometrySample]) -> PosePath:
        """The path that the messages on an odometry topic tell."""
        stamps = stamps_or_recorded([s.stamp for s in samples], [s.recorded for s in samples])
        return cls(topic, samples[0].base, stamps, increasing_times(stamps), np.array([s.pose for s in samples]))

    @classmethod
    def from_edge(cls, base: str, edge: Edge) -> PosePath:
        """The path of a moving frame."""
        stamps = stamps_or_recorded(edge.stamps, edge.recorded)
        poses = np.array([planar(transform) for transform in edge.transforms])
        return cls(f"TF {edge.parent} → {base}", base, stamps, increasing_times(stamps), poses)

    def at(self, times: Float[np.ndarray, "m"]) -> Float[np.ndarray, "m 3"]:
        """Poses at other times, held constant beyond the ends."""
        return interpolate_poses(self.times, self.poses, times)
