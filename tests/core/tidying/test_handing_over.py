"""Beams that are handed over are given to whom it was said, and no other association changes."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.association import Verdict
from bspline_slam.sights import collect_sights, pieces_of
from bspline_slam.tidying.handing_over import handed_over, renamed
from core.doubled import beams, longest, room


def test_nothing_changes_where_every_beam_stays() -> None:
    keys, splines, _ = room()
    sights = collect_sights(keys, splines)
    own = np.array([spline.id for spline in splines])[sights.spline]
    after = handed_over(keys, splines, sights, own, np.zeros(len(own)))
    assert all(one is other for one, other in zip(after, keys, strict=True))


@pytest.mark.parametrize("seed", range(3))
def test_each_beam_goes_to_its_owner(seed: int) -> None:
    keys, splines, _ = room()
    rng, sights = np.random.default_rng(seed), collect_sights(keys, splines)
    ids = np.array([spline.id for spline in splines])
    owners = np.where(rng.random(len(sights.spline)) < 0.05, 1000, ids[sights.spline])
    after = beams(handed_over(keys, splines, sights, owners, np.full(len(owners), 0.02)))
    expected = {}
    for (_, pose, number), piece in zip(pieces := pieces_of(keys, splines), range(len(pieces)), strict=True):
        association = keys[pose].associations[number]
        for beam, owner in zip(keys[pose].beams_of(association), owners[sights.piece == piece], strict=True):
            expected[pose, association.segment, int(beam)] = int(owner)
    assert after == expected


def test_what_is_handed_over_says_how_far_it_lies_from_its_new_spline() -> None:
    keys, splines, _ = room()
    sights, wall = collect_sights(keys, splines), longest(splines)
    ids = np.array([spline.id for spline in splines])[sights.spline]
    after = handed_over(keys, splines, sights, np.where(ids == wall.id, 1000, ids), np.full(len(ids), -0.02))
    moved = [a for key in after for a in key.associations if a.spline == 1000]
    assert moved and all(a.verdict is Verdict.MATCHED and a.distance == pytest.approx(0.02) for a in moved)


def test_a_new_name_is_taken_over_everywhere() -> None:
    keys, splines, _ = room()
    names = {longest(splines).id: 77}
    after = beams(renamed(keys, names))
    assert after == {beam: names.get(spline, spline) for beam, spline in beams(keys).items()}
