"""Corners of walls: found where curves cross, held together when curves move, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, clamped_between
from bspline_slam.corners import LOOSE, corners_of, crossing, end_crossing, ends_and_starts, meeting
from bspline_slam.spline_map import MapSpline, SplineMap


def wall(number: int, *, pose: tuple[float, float, float], span: tuple[float, float], bend: float = 0.0) -> MapSpline:
    """A wall along the x axis of `pose`, bent by up to `bend` (m), known from 1 m before to 4 m behind its origin."""
    flat = BSpline(3, clamped_between(-1.0, 4.0, 6), np.zeros((6, 2)))
    points = np.column_stack([flat.greville(), bend * np.array([0.0, 0.0, 1.0, -1.0, 1.0, 0.0])])
    return MapSpline(number, flat.with_control_points(points).moved(np.array(pose)), span, 0)


def niche(turn: float = np.pi / 2, *, short: float = 0.03, over: float = 0.02, bend: float = 0.0) -> SplineMap:
    """Two walls: the first ends `short` of the origin, the second starts `over` before it, turned left by `turn`."""
    first = wall(3, pose=(-2.0, 0.0, 0.0), span=(0.0, 2.0 - short), bend=bend)
    return SplineMap((first, wall(7, pose=(0.0, 0.0, turn), span=(-over, 2.0))))


@pytest.mark.parametrize("turn", [np.pi / 2, -np.pi / 2, 0.7, -2.4])
def test_walls_meet_where_they_cross(turn: float) -> None:
    after = meeting(niche(turn), [(3, 7)])
    (corner,) = corners_of(after)
    assert corner.joint == (3, 7)
    assert corner.turn == pytest.approx(turn, abs=1e-9)
    np.testing.assert_allclose(corner.point, 0.0, atol=1e-9)
    assert corners_of(niche(turn)) == ()


@pytest.mark.parametrize("seed", range(5))
def test_curved_walls_that_move_a_little_meet_again(seed: int) -> None:
    rng, joined = np.random.default_rng(seed), meeting(niche(bend=0.1), [(3, 7)])
    moved = SplineMap(
        tuple(
            replace(one, curve=one.curve.with_control_points(one.curve.control_points + rng.normal(0.0, 0.005, (6, 2))))
            for one in joined
        )
    )
    assert corners_of(moved) == ()
    again = meeting(moved, [(3, 7)])
    (corner,) = corners_of(again)
    np.testing.assert_allclose(corner.point, again[7].curve(np.array([again[7].span[0]]))[0], atol=1e-9)
    assert all(one.curve is other.curve for one, other in zip(moved, again, strict=True))


def test_a_corner_goes_along_with_the_map() -> None:
    motion = np.array([3.0, -1.0, 2.0])
    (here,) = corners_of(meeting(niche(), [(3, 7)]))
    (there,) = corners_of(meeting(SplineMap(tuple(one.moved(motion) for one in niche())), [(3, 7)]))
    np.testing.assert_allclose(there.point, motion[:2] + here.point, atol=1e-9)
    assert there.turn == pytest.approx(here.turn)


def test_a_corner_that_is_one_stays_as_it_is() -> None:
    joined = meeting(niche(), [(3, 7)])
    assert all(one is other for one, other in zip(joined, meeting(joined, [(3, 7)]), strict=True))


@pytest.mark.parametrize(
    "splines",
    [niche(short=2 * LOOSE), niche(over=2 * LOOSE), niche(turn=0.2), niche(turn=3.0)],
    ids=["short", "over", "slanting", "folded"],
)
def test_what_has_come_apart_stays_as_it_is(splines: SplineMap) -> None:
    assert all(one is other for one, other in zip(splines, meeting(splines, [(3, 7)]), strict=True))


def test_the_end_of_a_domain_is_the_end_of_a_curve() -> None:
    before, after = niche(short=0.03)
    cut = replace(before, curve=before.curve.clamped((-1.0, 1.97)))
    splines = SplineMap((cut, after))
    assert end_crossing(cut, after) is not None
    assert meeting(splines, [(3, 7)]).splines == splines.splines


def test_joints_of_splines_that_are_gone_say_nothing() -> None:
    splines = niche()
    assert meeting(splines, [(3, 8), (1, 7)]).splines == splines.splines


def test_a_wall_that_goes_straight_on_has_no_corner() -> None:
    whole = wall(0, pose=(0.0, 0.0, 0.3), span=(0.0, 1.0))
    assert corners_of(SplineMap((whole, replace(whole, id=1, span=(1.0, 2.0))))) == ()
    assert corners_of(SplineMap()) == ()


def test_ends_are_paired_with_the_starts_near_them_alone() -> None:
    rng = np.random.default_rng(4)
    walls = [wall(k, pose=(*rng.uniform(0.0, 6.0, 2), rng.uniform(-3.0, 3.0)), span=(0.0, 1.0)) for k in range(60)]
    ends, starts = (np.array([one.curve(np.array([one.span[k]]))[0] for one in walls]) for k in (1, 0))
    near = np.abs(ends[:, None] - starts[None]).max(-1) <= 0.8
    np.fill_diagonal(near, False)
    assert sorted(ends_and_starts(SplineMap(tuple(walls)), 0.8)) == list(zip(*map(list, np.nonzero(near)), strict=True))
    assert near.sum() > 10


def test_parallel_curves_do_not_cross() -> None:
    one, other = wall(0, pose=(0.0, 0.0, 0.0), span=(0.0, 1.0)), wall(1, pose=(1.0, 0.1, 0.0), span=(0.0, 1.0))
    assert crossing(one.curve, 1.0, other.curve, 0.0) is None
