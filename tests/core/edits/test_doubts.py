"""The queue of doubts: what is close comes first, what a hand decided only where it lies far off."""

from __future__ import annotations

from dataclasses import replace

from bspline_slam.association import Association, Candidate
from bspline_slam.edits.amend import amended
from bspline_slam.edits.doubts import doubts
from bspline_slam.edits.edit import Force, OnPiece
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot


def with_piece(base: Snapshot, piece: Association, changed: Association) -> Snapshot:
    keys = tuple(
        replace(key, associations=tuple(changed if a is piece else a for a in key.associations))
        for key in base.observations
    )
    return replace(base, observations=keys)


def test_a_piece_between_two_splines_is_the_greatest_doubt(
    base: Snapshot, config: SlamConfig, piece: Association
) -> None:
    other = next(spline.id for spline in base.map if spline.id != piece.spline)
    rival = Candidate(other, piece.distance + 1e-4, 1.0)
    close = replace(piece, candidates=(*piece.candidates, rival))
    queue = doubts(with_piece(base, piece, close), config)
    first = queue[0]
    assert first.piece == OnPiece(piece.scan, piece.segment, piece.first, piece.last)
    assert [doubt.score for doubt in queue] == sorted((doubt.score for doubt in queue), reverse=True)
    assert str(other) in first.sentence
    (overrule,) = first.overrule
    assert isinstance(overrule, Force) and overrule.spline == other


def test_a_match_near_the_gate_is_doubted_and_one_by_hand_only_beyond_it(
    base: Snapshot, config: SlamConfig, piece: Association
) -> None:
    far = replace(piece, distance=0.95 * piece.gate, candidates=())
    about = OnPiece(piece.scan, piece.segment, piece.first, piece.last)
    assert about in {doubt.piece for doubt in doubts(with_piece(base, piece, far), config)}
    by_hand = replace(far, by="hand")
    assert about not in {doubt.piece for doubt in doubts(with_piece(base, piece, by_hand), config)}
    beyond = replace(by_hand, distance=2.0 * piece.gate)
    assert doubts(with_piece(base, piece, beyond), config)[0].piece == about


def test_every_doubt_can_be_overruled_as_it_says(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    far = replace(piece, distance=0.95 * piece.gate, candidates=())
    doubtful = with_piece(base, piece, far)
    for doubt in doubts(doubtful, config)[:5]:
        assert 0.5 <= doubt.score <= 1.0
        assert amended(doubtful, doubt.overrule, config).skipped == (None,) * len(doubt.overrule)
