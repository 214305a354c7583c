"""Curves part where beams leave a gap; nothing that was seen is lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.adjustment.trimming import TrimmingConfig
from bspline_slam.models import NormalDistance
from bspline_slam.sights import KeyObservations, collect_sights, find_feet
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.parting import parted
from core.doubled import beams, longest, room


def part(
    keys: tuple[KeyObservations, ...], splines: SplineMap, poses: np.ndarray
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, poses, 0.15, 0.05)
    return parted(keys, splines, sights, feet, TrimmingConfig(gap_ratio=1.0), NormalDistance())


def with_hole(
    keys: tuple[KeyObservations, ...], splines: SplineMap, poses: np.ndarray, width: float
) -> tuple[KeyObservations, ...]:
    """Key scans that saw nothing of the middle of the longest wall, `width` (m) wide."""
    wall = longest(splines)
    middle = wall.curve(np.array([np.mean(wall.span)]))[0]
    out = []
    for key, pose in zip(keys, poses, strict=True):
        away = [np.linalg.norm(se2.transform(pose, s.points) - middle, axis=1) > width / 2 for s in key.segments]
        left = zip(key.segments, away, strict=True)
        segments = (replace(s, beams=s.beams[kept], points=s.points[kept]) for s, kept in left)
        out.append(replace(key, segments=tuple(segments)))
    return tuple(out)


def test_a_gap_makes_two_splines_of_one_and_the_longer_keeps_the_id() -> None:
    keys, splines, poses = room()
    torn, wall = with_hole(keys, splines, poses, 1.0), longest(splines)
    after, tidy = part(torn, splines, poses)
    (rest,) = (spline for spline in tidy if f"parted from spline {wall.id} at a gap" in spline.history)
    assert rest.id > max(spline.id for spline in splines)
    assert tidy[wall.id].length >= rest.length
    assert tidy[wall.id].length + rest.length < wall.length - 0.9
    moved = {beam for beam, spline in beams(after).items() if spline == rest.id}
    before = beams(torn)
    assert moved and all(before[beam] == wall.id for beam in moved)
    assert {beam for beam, spline in before.items() if spline == wall.id} == moved | {
        beam for beam, spline in beams(after).items() if spline == wall.id
    }


def test_beams_go_to_the_side_of_the_gap_that_they_lie_on() -> None:
    keys, splines, poses = room()
    wall = longest(splines)
    after, tidy = part(with_hole(keys, splines, poses, 1.0), splines, poses)
    middle = wall.curve(np.array([np.mean(wall.span)]))[0]
    for spline in (one for one in tidy if one.history[: len(wall.history)] == wall.history):
        out = (spline.curve(np.array([np.mean(spline.span)]))[0] - middle) / spline.length
        for pose, key in enumerate(after):
            for association in (a for a in key.associations if a.spline == spline.id):
                segment = next(s for s in key.segments if s.index == association.segment)
                inside = np.isin(segment.beams, key.beams_of(association))
                ends = se2.transform(poses[pose], segment.points[inside])
                assert np.all((ends - middle) @ out > 0.0)
