"""Curves that show one wall become one, with all beams; what is no such wall stays as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st

from bspline_slam.lab.double_walls import double_walls
from bspline_slam.sights import KeyObservations, collect_sights, find_feet
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.merging import MergingConfig, merged, steadied
from core.doubled import beams, given, longest, room

SMEAR = 2.0


def merge(
    keys: tuple[KeyObservations, ...],
    splines: SplineMap,
    poses: np.ndarray,
    config: MergingConfig | None = None,
    smear: float = SMEAR,
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    sights = collect_sights(keys, splines)
    feet = find_feet(sights, splines, poses, 0.15, 0.05)
    sigma = np.full(len(feet.t), 0.012)
    return merged(keys, splines, sights, feet, sigma, smear, config or MergingConfig())


def ids(splines: SplineMap) -> list[int]:
    return [spline.id for spline in splines]


def with_copy(splines: SplineMap, *, aside: float = 0.0) -> SplineMap:
    """The map with the longest wall once more, as spline 1000, that much in front of itself."""
    wall = longest(splines)
    off = aside * wall.curve.normals(np.array([np.mean(wall.span)]))[0]
    curve = wall.curve.with_control_points(wall.curve.control_points + off)
    return SplineMap((*splines, replace(wall, id=1000, curve=curve)))


def test_a_map_without_doubles_stays_as_it_is() -> None:
    keys, splines, poses = room()
    after, tidy = merge(keys, splines, poses)
    assert ids(tidy) == ids(splines) and beams(after) == beams(keys)
    assert all(one.curve is other.curve for one, other in zip(tidy, splines, strict=True))


@pytest.mark.parametrize("share", [3, 2, 1])
@pytest.mark.parametrize("aside", [0.0, 0.03])
def test_a_wall_shown_twice_becomes_one_under_the_older_id(share: int, aside: float) -> None:
    keys, splines, poses = room()
    torn = given(keys, longest(splines).id, 1000, lambda pose: pose % 4 < share)
    after, tidy = merge(torn, with_copy(splines, aside=aside), poses)
    assert ids(tidy) == ids(splines)
    assert beams(after) == beams(keys)
    assert any("merged with spline 1000" in sentence for sentence in tidy[longest(splines).id].history)


def test_curves_that_overlap_in_part_share_no_stretch_any_more() -> None:
    keys, splines, poses = room()
    wall, torn = longest(splines), with_copy(splines)
    low, high = wall.span
    spans = {wall.id: (low, low + 0.6 * (high - low)), 1000: (low + 0.4 * (high - low), high)}
    torn = SplineMap(tuple(replace(one, span=spans.get(one.id, one.span)) for one in torn))
    handed = given(keys, wall.id, 1000, lambda pose: pose % 2 == 0)
    after, tidy = merge(handed, torn, poses)
    assert ids(tidy) == ids(torn) and beams(after).keys() == beams(keys).keys()
    told = next(spline for spline in tidy if any("the same wall" in sentence for sentence in spline.history))
    sights = collect_sights(after, tidy)
    feet = find_feet(sights, tidy, poses, 0.15)
    left = feet.t[feet.counts & (sights.spline == ids(tidy).index(told.id))]
    span = (float(left.min()), float(left.max()))
    cut = SplineMap(tuple(replace(one, span=span) if one.id == told.id else one for one in tidy))
    assert double_walls(torn) > 0.15 * wall.length
    assert double_walls(cut) < 0.25


def test_two_surfaces_that_the_same_scans_saw_stay_two() -> None:
    keys, splines, poses = room()
    wall = longest(splines)
    together = tuple(
        replace(
            key,
            associations=tuple(
                part
                for a in key.associations
                for part in (
                    (replace(a, last=a.first + (a.last - a.first) // 2), replace(a, first=a.last, spline=1000))
                    if a.spline == wall.id and a.last - a.first > 4
                    else (a,)
                )
            ),
        )
        for key in keys
    )
    careful = MergingConfig(same=0.0, together=0.0)
    assert ids(merge(together, with_copy(splines), poses, careful)[1]) == ids(with_copy(splines))
    assert ids(merge(together, with_copy(splines), poses)[1]) == ids(splines)


def test_curves_whose_beams_would_not_agree_stay_two() -> None:
    keys, splines, poses = room()
    torn = given(keys, longest(splines).id, 1000, lambda pose: pose % 2 == 0)
    assert ids(merge(torn, with_copy(splines), poses, smear=0.1)[1]) == ids(with_copy(splines))


def test_two_faces_of_a_wall_stay_two() -> None:
    keys, splines, poses = room()
    wall = longest(splines)
    back = replace(wall, id=1000, curve=wall.curve.reversed())
    faces = SplineMap((*splines, replace(back, span=back.curve.domain)))
    assert ids(merge(keys, faces, poses)[1]) == ids(faces)


def test_an_empty_map_stays_empty() -> None:
    keys, _, poses = room()
    after, tidy = merge(keys, SplineMap(), poses)
    assert after == keys and len(tidy) == 0


@drawn(st.lists(st.integers(-1, 2), min_size=1, max_size=40), st.integers(1, 5))
def test_steadied_values_have_no_short_runs(values: list[int], least: int) -> None:
    before = np.array(values)
    after = steadied(before, least)
    runs = np.diff(np.flatnonzero(np.diff(after, prepend=after[0] - 1, append=after[-1] - 1)))
    assert len(runs) == 1 or runs.min() >= least
    assert set(after.tolist()) <= set(values)
    assert np.array_equal(steadied(after, least), after)
