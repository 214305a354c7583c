"""The part of the world that a page is to look at to see what is selected."""

from __future__ import annotations

import numpy as np

from splinescope.browser.values import Bounds
from splinescope.edits.subject import Subject
from splinescope.pieces import name_of_piece, points_of
from splinescope.view import MapView, ScanView, Selection

AROUND = 1.0
"""So much (m) of what lies around a thing is shown with it."""


def surroundings(
    scan: ScanView | None, world: MapView | None, subject: Subject, selection: Selection | None
) -> Bounds | None:
    """The rectangle around what is selected, or else around the robot; None where nothing is shown."""
    if scan is None or world is None:
        return None
    points = [scan.pose[None, :2]]
    if subject.chosen:
        points = [points_of(name_of_piece(piece), scan) for piece in subject.chosen]
    elif subject.spline is not None:
        points = [subject.spline.sample(0.2)[1]]
    elif selection is not None and selection.kind == "closure" and selection.id < len(world.loop_closures):
        closure, poses = world.loop_closures[selection.id], dict(zip(world.key_scans, world.key_poses, strict=False))
        points = [poses[end][None, :2] for end in (closure.earlier, closure.scan) if end in poses]
    elif subject.pose is not None:
        points = [subject.pose[None, :2]]
    together = np.concatenate(points)
    (left, low), (right, high) = together.min(axis=0) - AROUND, together.max(axis=0) + AROUND
    return float(left), float(low), float(right), float(high)
