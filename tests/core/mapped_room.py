"""A room that scans were taken in and mapped, for tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.association import AssociationConfig
from bspline_slam.front_end.mapping import MapBuilder
from bspline_slam.graph import PoseFactor
from bspline_slam.models import Model, NormalDistance
from bspline_slam.segmentation import segment_scan
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import SplineMap
from core.rooms import loop_path, room_scan

MODEL = NormalDistance()
PATH = loop_path(16)


def seen_from(
    poses: np.ndarray, seed: int = 0, model: Model = MODEL
) -> tuple[list[KeyObservations], SplineMap, list[PoseFactor]]:
    """Scans taken on PATH, mapped at `poses`, with odometry between them of 5 cm and 3°."""
    rng, builder = np.random.default_rng(seed), MapBuilder(AssociationConfig(), model)
    keys = []
    for k, truth in enumerate(PATH):
        scan = room_scan(truth, rng, index=k)
        segments = segment_scan(scan)
        decided = builder.add(k, poses[k], segments)
        keys.append(KeyObservations(k, segments, decided, int(scan.valid.sum()), scan.pose_robot_sensor[:2]))
    keys = [
        replace(
            key,
            associations=tuple(
                a if a.spline is None else replace(a, spline=builder.heir(a.spline)) for a in key.associations
            ),
        )
        for key in keys
    ]
    steps = se2.between(PATH[:-1], PATH[1:]) + rng.normal(0, [0.02, 0.02, 0.01], (len(PATH) - 1, 3))
    root = np.diag([1 / 0.05, 1 / 0.05, 1 / 0.05])
    return keys, builder.map, [PoseFactor(k, k + 1, step, root) for k, step in enumerate(steps)]


def disturbed(size: float) -> np.ndarray:
    """PATH with errors of this size (m), and of three tenths of it in turns (rad), but for its first pose."""
    noise = np.random.default_rng(9).normal(0, [size, size, 0.3 * size], PATH.shape)
    noise[0] = 0.0
    return se2.compose(PATH, noise)
