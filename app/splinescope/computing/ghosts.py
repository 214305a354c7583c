"""What looks different when edits are made, before the exact map is there."""

from __future__ import annotations

import numpy as np

from bspline_slam.edits.decisions import Decisions
from bspline_slam.slam import Snapshot
from bspline_slam.spline_map import SplineMap
from splinescope.computing.edit_messages import Ghost

MOVED = 1e-3
"""What moves by less than this (m) is not in the ghost."""


def ghost_of(before: Snapshot, decisions: Decisions) -> Ghost:
    """What looks different from a result: poses and splines that moved, splines that came, were drawn anew or left,
    key scans and loop closures that were decided otherwise."""
    now = {spline.id: spline.curve.control_points for spline in before.map}
    different = tuple(
        spline
        for spline in decisions.splines
        if (old := now.get(spline.id)) is None
        or old.shape != spline.curve.control_points.shape
        or np.abs(old - spline.curve.control_points).max() > MOVED
    )
    poses = before.poses_with(decisions.poses)
    moved = np.linalg.norm((poses - before.poses)[:, :2], axis=1).max(initial=0.0) > MOVED
    kept = {spline.id for spline in decisions.splines}
    decided = {
        key.scan: key.associations
        for old, key in zip(before.observations, decisions.keys, strict=True)
        if key.associations != old.associations
    }
    closures = decisions.closures if decisions.closures is not before.loop_closures else None
    gone = tuple(number for number in now if number not in kept)
    return Ghost(poses if moved else None, SplineMap(different), gone, decided, closures)
