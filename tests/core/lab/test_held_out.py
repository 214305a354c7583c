"""Held-out beams: curves are fitted to the even beams alone, and the odd ones tell how well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.lab.crispness import crispness, nearest_curves
from bspline_slam.lab.held_out import held_out, nearest_sights, refitted
from bspline_slam.lab.wall_beams import WallBeams, scans_apart
from bspline_slam.slam_config import SlamConfig
from bspline_slam.spline_map import SplineMap
from core.lab.walls import beams, room

CONFIG = SlamConfig()


def bent(splines: SplineMap, by: float) -> SplineMap:
    """The map with every control point off by a random amount."""
    rng = np.random.default_rng(3)
    return SplineMap(
        tuple(
            replace(s, curve=s.curve.with_control_points(s.curve.control_points + rng.uniform(-by, by, (7, 2))))
            for s in splines
        )
    )


def only(seen: WallBeams, odd: bool) -> WallBeams:
    return seen.part((seen.beam % 2 == 1) == odd)


def test_odd_beams_have_no_say_in_the_fit() -> None:
    seen = beams(0.01)
    wrong = replace(seen, points=seen.points + 0.02 * seen.directions * (seen.beam % 2)[:, None])
    right, led = (refitted(only(each, odd=False), room(), CONFIG) for each in (seen, wrong))
    for a, b in zip(right, led, strict=True):
        assert np.array_equal(a.curve.control_points, b.curve.control_points)
    assert held_out(wrong, room(), CONFIG).rms > 1.3 * held_out(seen, room(), CONFIG).rms


def test_a_bent_map_is_straight_after_the_fit() -> None:
    seen = beams(0.01)
    assert crispness(only(seen, odd=True), bent(room(), 0.03)).rms > 0.012
    noise = crispness(only(seen, odd=True), room()).rms
    assert held_out(seen, bent(room(), 0.03), CONFIG).rms == pytest.approx(noise, rel=0.1)


def test_beams_that_were_fitted_lie_nearer_than_those_held_out() -> None:
    gaps = []
    for seed in range(4):
        seen = beams(0.012, seed)
        fitted = refitted(only(seen, odd=False), room(), CONFIG)
        gaps.append(crispness(only(seen, odd=True), fitted).rms - crispness(only(seen, odd=False), fitted).rms)
    assert np.mean(gaps) > 0


def test_curves_that_no_beam_reaches_are_left_out() -> None:
    seen, walls = beams(0.01), room()
    near = seen.part(nearest_curves(seen, walls)[1] == 2)
    assert len(near) > 0
    assert [spline.id for spline in refitted(near, walls, CONFIG)] == [walls.splines[2].id]


def test_sights_are_sorted_and_pieces_are_of_one_scan_and_curve() -> None:
    sights = nearest_sights(beams(0.01), room())
    assert np.all(np.diff(sights.spline) >= 0) and np.all(np.isin(np.diff(sights.piece), (0, 1)))
    pairs = np.unique(np.stack([sights.spline, sights.pose, sights.piece], -1), axis=0)
    assert len(pairs) == sights.piece.max() + 1 == len(np.unique(pairs[:, :2], axis=0))


def test_chosen_scans_lie_apart() -> None:
    rng = np.random.default_rng(1)
    poses = np.cumsum(rng.uniform(-0.05, 0.1, (300, 3)) * [1, 1, 0.3], axis=0)
    config = TrackingConfig()
    chosen = scans_apart(poses, config)
    step = np.diff(poses[chosen], axis=0)
    assert chosen[0] == 0
    assert np.all((np.hypot(step[:, 0], step[:, 1]) > config.distance) | (np.abs(step[:, 2]) > config.turn))
