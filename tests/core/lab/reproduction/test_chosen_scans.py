"""The rule by which a few scans and splines of a log are chosen."""

from __future__ import annotations

import numpy as np

from bspline_slam.lab.reproduction.chosen_scans import (
    OVERLAP,
    Wall,
    WallSight,
    chosen_scans,
    chosen_splines,
    continuing,
)


def random_walls(rng: np.random.Generator) -> list[Wall]:
    """Sixty scans, each of which sees some cells in a row of one or two of six splines."""
    walls = []
    for _ in range(60):
        starts = [(int(rng.integers(6)), int(rng.integers(20))) for _ in range(rng.integers(1, 3))]
        walls.append(frozenset((spline, start + n) for spline, start in starts for n in range(8)))
    return walls


def sight(spline: int, first: int, last: int) -> WallSight:
    return WallSight(spline, np.zeros((0, 2)), frozenset((spline, n) for n in range(first, last)))


def test_every_chosen_scan_finds_half_of_its_wall_on_the_map_before_it() -> None:
    for seed in range(5):
        walls = random_walls(np.random.default_rng(seed))
        chosen = chosen_scans(walls, 12)
        assert len(set(chosen)) == len(chosen) > 3
        assert len(walls[chosen[0]]) == max(map(len, walls))
        for k in range(1, len(chosen)):
            known = frozenset().union(*(walls[scan] for scan in chosen[:k]))
            assert len(walls[chosen[k]] & known) >= OVERLAP * len(walls[chosen[k]])


def test_scans_that_share_nothing_are_not_chosen() -> None:
    walls = [frozenset((spline, n) for n in range(5)) for spline in range(4)]
    assert chosen_scans(walls, 4) == (0,)


def test_another_stretch_of_a_spline_waits_until_what_lies_between_is_known() -> None:
    seen = [[sight(1, 0, 4)], [sight(1, 8, 12), sight(2, 0, 3)], [sight(1, 3, 9)], [sight(1, 8, 12)]]
    assert [[s.spline for s in sights] for sights in continuing(seen)] == [[1], [2], [1], [1]]


def test_splines_rank_by_the_stretch_that_two_scans_saw() -> None:
    walls = [
        sight(1, 0, 9).cells | sight(2, 0, 5).cells,
        sight(1, 7, 20).cells | sight(2, 1, 5).cells,
        sight(3, 0, 50).cells,
    ]
    assert chosen_splines(walls, 5) == (2, 1)
