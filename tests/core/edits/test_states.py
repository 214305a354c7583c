"""Results with edits that are remembered, and that what is made from them is the same as what is made anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam.edits.amend import amended, steps_of
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    MergeSplines,
    PinPose,
    PinSpline,
    SplitSegment,
    SplitSpline,
)
from bspline_slam.edits.loop_edits import close_loop, moved_poses
from bspline_slam.edits.states import APART, LATEST, MILESTONES, States
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot
from core.edits.test_ties import wrong_loop

MADE = FIRST_MADE_BY_HAND


def edits_on(base: Snapshot) -> list[Edit]:
    """Edits of many kinds, each on another key scan or on a spline."""
    out: list[Edit] = []
    for number in range(2, len(base.observations) - 2, 2):
        given = (a for a in base.observations[number].associations if a.spline is not None and a.spline in base.map)
        piece = max(given, key=lambda a: a.last - a.first)
        assert piece.spline is not None
        where, spline = (piece.scan, piece.segment, piece.first, piece.last), base.map[piece.spline]
        x, y = spline.curve(np.array([np.mean(spline.span)]))[0].tolist()
        pose = (base.steps[number].pose + np.array([0.01, 0.0, 0.0])).tolist()
        of_each: list[Edit] = [
            Ignore(*where), Force(*where, spline.id), SplitSegment(piece.scan, piece.segment, piece.first + 5),
            PinPose(piece.scan, (pose[0], pose[1], pose[2])), SplitSpline(spline.id, (x, y), MADE + number),
            MakeNew(*where, MADE + number), PinSpline.at(spline.id, spline.curve, spline.span),
            Forbid(*where, spline.id), MergeSplines(spline.id, MADE + number),
        ]  # fmt: skip
        out.append(of_each[(number // 2) % len(of_each)])
    return out


def told(snapshot: Snapshot) -> list[tuple[object, ...]]:
    """Which beams are given to which spline, and by whom."""
    return [(a.scan, a.segment, a.first, a.last, a.spline, a.by) for s in snapshot.steps for a in s.associations]


def same(one: Snapshot, other: Snapshot) -> bool:
    """Whether two results are the same to the last bit."""
    curves = zip(one.map, other.map, strict=True)
    return (
        np.array_equal(one.poses, other.poses)
        and told(one) == told(other)
        and all(
            a.id == b.id
            and a.observations == b.observations
            and np.array_equal(a.curve.control_points, b.curve.control_points)
            for a, b in curves
        )
    )


@pytest.mark.parametrize("seed", [0, 1])
def test_what_is_gone_on_from_is_what_a_replay_makes(base: Snapshot, config: SlamConfig, seed: int) -> None:
    rng, states = np.random.default_rng(seed), States(base, config)
    edits = edits_on(base)
    rng.shuffle(edits)  # type: ignore[arg-type]
    chosen = tuple(edits[:5])
    for size in range(1, len(chosen) + 1):
        amended(base, chosen[:size], config, states=states)
    for left_out in (None, 1, 3):
        wanted = tuple(edit for number, edit in enumerate(chosen) if number != left_out)
        remembered, anew = amended(base, wanted, config, states=states), amended(base, wanted, config)
        assert remembered.skipped == anew.skipped
        assert same(remembered.snapshot, anew.snapshot)


def test_a_map_that_a_loop_bends_is_made_anew_with_all_edits(base: Snapshot, config: SlamConfig) -> None:
    states, ignore = States(base, config), edits_on(base)[0]
    before = amended(base, (ignore,), config, states=states).ground
    closed = close_loop(before.decisions, wrong_loop(base), config)
    assert moved_poses(before.decisions, closed, config) is not None
    after = amended(base, (ignore, wrong_loop(base)), config, states=states)
    assert after.skipped == (None, None)
    assert same(after.snapshot, amended(base, (ignore, wrong_loop(base)), config).snapshot)
    onwards = (ignore, wrong_loop(base), edits_on(base)[3])
    assert same(amended(base, onwards, config, states=states).snapshot, amended(base, onwards, config).snapshot)


def test_pieces_of_one_scan_are_made_together() -> None:
    a, b, c = Ignore(5, 0, 0, 9), Forbid(5, 1, 0, 9, 3), Ignore(6, 0, 0, 9)
    pin = PinPose(5, (0.0, 0.0, 0.0))
    assert steps_of(()) == []
    assert steps_of((a, b, c)) == [2, 3]
    assert steps_of((a, pin, b)) == [1, 2, 3]
    assert steps_of((pin, pin)) == [1, 2]


def test_the_latest_and_some_far_ones_are_remembered(base: Snapshot, config: SlamConfig) -> None:
    states, every = States(base, config), tuple(Ignore(scan, 0, 0, 9) for scan in range(10 * APART))
    made, footing = states[()], states.footing(())
    for size in range(1, len(every) + 1):
        states.keep(every[:size], replace(made), footing)
    known = [size for size in range(len(every) + 1) if every[:size] in states]
    assert known[0] == 0 and len(known) <= 1 + LATEST + MILESTONES
    assert set(range(len(every) - LATEST + 1, len(every) + 1)) <= set(known)
    assert states.nearest(every[: 9 * APART - 1]) == every[: 8 * APART]
    assert states.nearest((PinPose(0, (0.0, 0.0, 0.0)),)) == ()
