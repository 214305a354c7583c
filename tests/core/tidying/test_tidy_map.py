"""The map that is adjusted shows each wall once, and tidying it again changes nothing."""

from __future__ import annotations

from dataclasses import replace

from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.lab.double_walls import double_walls
from bspline_slam.models import ChordLength, NormalDistance
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import SplineMap
from bspline_slam.tidying.merging import MergingConfig
from bspline_slam.tidying.tidy_map import counted, tidied
from core.doubled import beams, given, longest, room


def tidy(
    keys: tuple[KeyObservations, ...], splines: SplineMap, model: NormalDistance | ChordLength | None = None
) -> tuple[tuple[KeyObservations, ...], SplineMap]:
    _, _, poses = room()
    return tidied(keys, poses, splines, MergingConfig(), AdjustmentConfig(), model or NormalDistance())


def test_a_double_wall_is_one_afterwards_and_tidying_again_changes_nothing() -> None:
    keys, splines, _ = room()
    wall = longest(splines)
    torn = given(keys, wall.id, 1000, lambda pose: pose % 2 == 0)
    double = SplineMap((*splines, replace(wall, id=1000)))
    once, after = tidy(torn, double)
    assert double_walls(double) > 0.9 * wall.length and double_walls(after) < 0.1
    again, same = tidy(once, after)
    assert [spline.id for spline in same] == [spline.id for spline in after]
    assert beams(again) == beams(once)


def test_the_published_model_derives_its_curves_itself() -> None:
    keys, splines, _ = room()
    assert tidy(keys, splines, ChordLength()) == (keys, splines)


def test_observations_count_key_scans() -> None:
    keys, splines, _ = room()
    for spline in counted(keys, splines):
        assert spline.observations == len({pose for (pose, *_), owner in beams(keys).items() if owner == spline.id})
