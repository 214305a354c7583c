"""Crispness: distances of beam ends to curves are what the geometry says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.lab.crispness import Crispness, crispness, nearest_curves
from bspline_slam.spline_map import MapSpline, SplineMap
from core.lab.walls import beams, room


def moved(splines: SplineMap, shift: np.ndarray) -> SplineMap:
    def one(spline: MapSpline) -> MapSpline:
        return replace(spline, curve=spline.curve.with_control_points(spline.curve.control_points + shift))

    return SplineMap(tuple(map(one, splines)))


def test_without_noise_only_the_steps_of_the_ranges_are_left() -> None:
    found = crispness(beams(0.0), room())
    assert found.beams > 1000 and found.within_3cm == 1.0
    assert found.rms <= 0.01 / np.sqrt(12) * 1.05  # uniform in ± 5 mm, less where beams slant


def test_noise_shows_as_large_as_it_is() -> None:
    seen, walls = beams(0.008), room()
    distance, curve = nearest_curves(seen, walls)
    normals = np.array([spline.curve.normals(np.array([0.5]))[0] for spline in walls])[curve]
    slant = np.abs((normals * seen.towards).sum(1))
    expected = np.sqrt(np.mean((slant * np.hypot(0.008, 0.01 / np.sqrt(12))) ** 2))
    assert np.sqrt(np.mean(distance**2)) == pytest.approx(expected, rel=0.08)


def test_each_beam_is_given_to_the_wall_that_it_ends_on() -> None:
    seen, walls = beams(0.0), room()
    _, curve = nearest_curves(seen, walls)
    feet = [spline.curve(spline.curve.foot_points(seen.ends)) for spline in walls]
    exact = np.array([np.linalg.norm(foot - seen.ends, axis=1) for foot in feet])
    clear = np.sort(exact, axis=0)[1] > 0.05  # not in a corner
    assert clear.mean() > 0.9 and np.array_equal(curve[clear], exact.argmin(0)[clear])


def test_a_wall_seen_from_behind_is_no_wall_of_these_beams() -> None:
    turned = SplineMap(tuple(replace(spline, curve=spline.curve.reversed()) for spline in room()))
    distance, curve = nearest_curves(beams(0.0), turned)
    assert np.all(np.isinf(distance)) and np.all(curve == -1)
    assert crispness(beams(0.0), turned).within_5cm == 0.0 and np.isnan(crispness(beams(0.0), turned).rms)


def test_where_map_and_poses_lie_together_does_not_matter() -> None:
    seen, walls, move = beams(0.01), room(), np.array([4.0, -2.0, 1.0])
    there = SplineMap(
        tuple(replace(s, curve=s.curve.with_control_points(se2.transform(move, s.curve.control_points))) for s in walls)
    )
    here = crispness(seen, walls)
    assert crispness(replace(seen, poses=se2.compose(move, seen.poses)), there).rms == pytest.approx(here.rms, rel=1e-3)


@pytest.mark.parametrize(("shift", "close", "crisp"), [(0.02, 1.0, 1.0), (0.04, 0.0, 1.0), (0.07, 0.0, 0.0)])
def test_shares_are_of_beams_within_3_and_5_centimetres(shift: float, close: float, crisp: float) -> None:
    seen = beams(0.0)
    wall = room().splines[2]
    mine = seen.part(nearest_curves(seen, SplineMap((wall,)))[0] < 0.006)
    found = crispness(mine, moved(SplineMap((wall,)), np.array([shift, 0.0])))
    assert (found.within_3cm, found.within_5cm) == (close, crisp)


def test_nothing_is_near_an_empty_map() -> None:
    found = crispness(beams(0.0), SplineMap())
    assert found.within_5cm == 0.0 and np.isnan(found.rms)
    assert np.isnan(Crispness.of(np.zeros(0)).within_3cm)
