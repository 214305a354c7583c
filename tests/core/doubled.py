"""A room whose map shows one wall twice, for tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from bspline_slam.association import Association
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import MapSpline, SplineMap
from core.mapped_room import PATH, seen_from

Beams = dict[tuple[int, int, int], int]


def room() -> tuple[tuple[KeyObservations, ...], SplineMap, np.ndarray]:
    """What key scans saw of a room, its map, and their poses."""
    keys, splines, _ = seen_from(PATH)
    return tuple(keys), splines, PATH


def longest(splines: SplineMap) -> MapSpline:
    return max(splines, key=lambda spline: spline.length)


def given(
    keys: Sequence[KeyObservations], spline: int, other: int, chosen: Callable[[int], bool]
) -> tuple[KeyObservations, ...]:
    """What the chosen key scans saw of a spline given to another."""

    def one(pose: int, association: Association) -> Association:
        mine = association.spline == spline and chosen(pose)
        return replace(association, spline=other) if mine else association

    return tuple(
        replace(key, associations=tuple(one(pose, association) for association in key.associations))
        for pose, key in enumerate(keys)
    )


def beams(keys: Sequence[KeyObservations]) -> Beams:
    """The spline of each beam, by the number of its key scan, its segment and its own number."""
    return {
        (pose, association.segment, beam): association.spline
        for pose, key in enumerate(keys)
        for association in key.associations
        if association.spline is not None
        for beam in key.beams_of(association).tolist()
    }
