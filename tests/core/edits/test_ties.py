"""Edits of ties: what they made is remembered, as long as the same are made on the same ground."""

from __future__ import annotations

from dataclasses import replace

from bspline_slam import se2
from bspline_slam.association import Association
from bspline_slam.edits.edit import CloseLoop, DropLoop, Ignore
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.ties import Ties
from bspline_slam.snapshot import Snapshot

ROOT = ((50.0, 0.0, 0.0), (0.0, 50.0, 0.0), (0.0, 0.0, 200.0))


def wrong_loop(base: Snapshot) -> CloseLoop:
    """A closure that moves the map by decimetres."""
    earlier, later = base.steps[0], base.steps[-1]
    x, y, theta = se2.between(earlier.pose, later.pose).tolist()
    return CloseLoop(earlier.scan, later.scan, (x + 0.5, y, theta), ROOT, 0.9, 0.9)


def test_a_map_is_built_anew_once_for_all_edits_that_follow(base: Snapshot, ground: Ground, piece: Association) -> None:
    ties, close = Ties(), wrong_loop(base)
    lost = [step.lost for step in base.steps]
    first = ties.made(ground, (close,), lost)
    assert first.ground is not ground
    ignore = Ignore(piece.scan, piece.segment, piece.first, piece.last)
    assert ties.made(ground, (close, ignore), lost) is first
    assert ties.made(ground, (ignore, close), lost) is first
    assert ties.made(ground, (ignore,), lost) is not first


def test_other_ties_and_another_ground_are_made_for_themselves(base: Snapshot, ground: Ground) -> None:
    ties, close = Ties(), wrong_loop(base)
    lost = [step.lost for step in base.steps]
    first = ties.made(ground, (close,), lost)
    drop = DropLoop(close.earlier, close.scan)
    assert ties.made(ground, (close, drop), lost) is not first
    elsewhere = replace(ground, config=ground.config)
    assert ties.made(elsewhere, (close,), lost) is not first
    assert ties.made(ground, (drop,), lost).skipped[0] is not None
