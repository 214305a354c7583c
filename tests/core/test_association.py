"""Cutting segments where the spline behind them changes, and what is recorded of the choice."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.association import (
    Association,
    AssociationConfig,
    Candidate,
    Explanation,
    Verdict,
    candidates_of,
    cut_into_pieces,
)

CONFIG = AssociationConfig()


def explanation(ids: list[list[int]], across: float = 0.01) -> Explanation:
    """Point j is near the splines `ids[j]` (−1: none), all at the same distance."""
    spline = np.array(ids)
    return Explanation(spline, np.zeros(spline.shape), np.full(spline.shape, across))


@given(st.lists(st.lists(st.integers(-1, 3), min_size=2, max_size=2, unique=True), min_size=1, max_size=40))
def test_pieces_cover_the_segment_without_gaps(ids: list[list[int]]) -> None:
    pieces = cut_into_pieces(explanation(ids), CONFIG)
    assert pieces[0].a == 0
    assert pieces[-1].b == len(ids)
    for one, following in pairwise(pieces):
        assert one.b == following.a
        assert one.spline is None or one.spline != following.spline
    for piece in pieces:
        if piece.spline is not None:
            near = (np.array(ids)[piece.a : piece.b] == piece.spline).any(1)
            assert near.sum() >= CONFIG.least_points


def test_a_segment_along_two_splines_is_cut_between_them() -> None:
    pieces = cut_into_pieces(explanation([[4, -1]] * 10 + [[7, -1]] * 6), CONFIG)
    assert [(p.a, p.b, p.spline) for p in pieces] == [(0, 10, 4), (10, 16, 7)]


def test_one_stray_beam_does_not_cut() -> None:
    pieces = cut_into_pieces(explanation([[4, -1]] * 5 + [[-1, -1]] + [[4, -1]] * 5), CONFIG)
    assert [(p.a, p.b, p.spline) for p in pieces] == [(0, 11, 4)]


def test_of_two_that_explain_everything_the_closer_is_taken() -> None:
    spline = np.array([[1, 2]] * 8)
    across = np.array([[0.05, 0.01]] * 8)
    pieces = cut_into_pieces(Explanation(spline, np.zeros((8, 2)), across), CONFIG)
    assert [p.spline for p in pieces] == [2]


def test_candidates_are_sorted_and_the_runner_up_is_the_best_other() -> None:
    seen = explanation([[1, 2]] * 6 + [[1, -1]] * 4)
    candidates = candidates_of(seen, 0, len(seen.spline))
    assert [(c.spline, c.overlap) for c in candidates] == [(1, 1.0), (2, 0.6)]
    chosen = Association(0, 0, 0, 9, Verdict.MATCHED, 1, 0.01, 0.1, candidates)
    assert chosen.runner_up == Candidate(2, candidates[1].distance, 0.6)


def test_nothing_near_means_no_candidates() -> None:
    assert candidates_of(explanation([[-1, -1]] * 5), 0, 5) == ()
