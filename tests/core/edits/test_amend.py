"""What edits do to a map: every kind on a simulated drive, on nothing but what hangs on it, and the same every time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.edits.amend import amended, solved_again
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    CloseLoop,
    DropLoop,
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
from bspline_slam.edits.explain import Fate, explain
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.making import decided
from bspline_slam.edits.piece_edits import rms_across
from bspline_slam.edits.settling import AT_REST, goes_on
from bspline_slam.edits.states import Amended
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.logs import open_log
from bspline_slam.slam import Slam, run_slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot

SAMPLES = Path(__file__).parents[3] / "sample_logs"
MADE = FIRST_MADE_BY_HAND


def longest_piece(base: Snapshot) -> Association:
    """The longest piece of a scan in the middle that is given to a spline."""
    pieces = base.observations[11].associations
    return max((a for a in pieces if a.spline is not None and a.spline in base.map), key=lambda a: a.last - a.first)


def where(piece: Association) -> tuple[int, int, int, int]:
    return piece.scan, piece.segment, piece.first, piece.last


def largest_move(base: Snapshot, after: Snapshot) -> float:
    return float(np.linalg.norm((after.poses - base.poses)[:, :2], axis=1).max())


def told(result: Amended, piece: Association) -> list[Association]:
    """What the result says of the beams of a piece."""
    step = next(step for step in result.snapshot.steps if step.scan == piece.scan)
    return [
        a for a in step.associations if a.segment == piece.segment and a.first <= piece.last and piece.first <= a.last
    ]


def made(base: Snapshot, config: SlamConfig, *edits: Edit) -> Amended:
    """The edits made, none of them skipped, and the result whole."""
    result = amended(base, edits, config)
    assert result.skipped == (None,) * len(edits)
    snapshot = result.snapshot
    assert snapshot.estimate is not None
    ids = [spline.id for spline in snapshot.map]
    assert ids == sorted(ids) == snapshot.estimate.graph.spline_ids.tolist()
    for step, pose in zip(snapshot.steps, snapshot.estimate.poses, strict=True):
        np.testing.assert_array_equal(step.pose, pose)
        np.testing.assert_allclose(snapshot.poses[step.scan], pose, atol=1e-9)
    return result


def same(a: Snapshot, b: Snapshot) -> bool:
    curves = zip(a.map, b.map, strict=True)
    return np.array_equal(a.poses, b.poses) and all(
        s.id == t.id and np.array_equal(s.curve.control_points, t.curve.control_points) for s, t in curves
    )


def test_without_edits_the_result_is_itself(base: Snapshot, config: SlamConfig) -> None:
    assert amended(base, (), config).snapshot is base


def test_the_same_edits_give_the_same_result_to_the_last_bit(
    base: Snapshot, config: SlamConfig, piece: Association
) -> None:
    edits = (Ignore(*where(piece)), SplitSegment(0, 0, 50))
    assert same(amended(base, edits, config).snapshot, amended(base, edits, config).snapshot)


def test_an_edit_that_says_nothing_new_moves_nothing(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    result = made(base, config, SplitSegment(piece.scan, piece.segment, (piece.first + piece.last) // 2))
    assert len(told(result, piece)) == 2
    assert {a.spline for a in told(result, piece)} == {piece.spline}
    assert largest_move(base, result.snapshot) < 2e-4


def test_an_ignored_piece_says_nothing_more(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    result = made(base, config, Ignore(*where(piece)))
    (association,) = told(result, piece)
    assert (association.verdict, association.spline, association.by) == (Verdict.IGNORED, None, "hand")
    assert 0 < largest_move(base, result.snapshot) < 0.02


def test_a_forbidden_pair_is_gone(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    assert piece.spline is not None
    result = made(base, config, Forbid(*where(piece), piece.spline))
    assert piece.spline not in {a.spline for a in told(result, piece)}
    again = made(base, config, *(Forbid(*where(piece), spline.id) for spline in base.map))
    assert {a.spline for a in told(again, piece)} == {None}


def test_a_forced_piece_is_given_to_the_spline(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    assert piece.spline is not None
    result = made(base, config, Force(*where(piece), piece.spline))
    (association,) = told(result, piece)
    assert (association.verdict, association.spline, association.by) == (Verdict.MATCHED, piece.spline, "hand")
    assert largest_move(base, result.snapshot) < 0.05


def test_a_spline_of_a_piece_alone_stays_in_the_map(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    result = made(base, config, MakeNew(*where(piece), MADE))
    spline = result.snapshot.map[MADE]
    assert spline.observations == 1
    assert rms_across(spline, Decisions.of(result.snapshot).points(Ignore(*where(piece)))) < 0.02


def test_a_split_spline_is_two_and_merged_again_one(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    assert piece.spline is not None
    spline = base.map[piece.spline]
    x, y = spline.curve(np.array([np.mean(spline.span)]))[0]
    split = SplitSpline(spline.id, (float(x), float(y)), MADE)
    two = made(base, config, split).snapshot
    assert len(two.map) == len(base.map) + 1
    assert two.map[spline.id].length + two.map[MADE].length == pytest.approx(spline.length, abs=0.1)
    assert two.map[spline.id].left_out == two.map[MADE].left_out == spline.left_out
    assert largest_move(base, two) < 0.03
    one = made(base, config, split, MergeSplines(spline.id, MADE)).snapshot
    assert len(one.map) == len(base.map)
    assert one.map[spline.id].length == pytest.approx(spline.length, abs=0.1)
    assert one.map[spline.id].left_out == spline.left_out
    samples = spline.sample(0.1)[1]
    assert rms_across(one.map[spline.id], samples) < 0.02


def test_a_pinned_pose_and_a_pinned_spline_are_where_they_are_pinned(base: Snapshot, config: SlamConfig) -> None:
    pose = se2.compose(base.steps[5].pose, np.array([0.02, 0.0, 0.01]))
    result = made(base, config, PinPose(base.steps[5].scan, (float(pose[0]), float(pose[1]), float(pose[2]))))
    np.testing.assert_allclose(result.snapshot.steps[5].pose, pose, atol=1e-4)
    spline = base.map.splines[0]
    aside = spline.curve.with_control_points(spline.curve.control_points + np.array([0.0, 0.01]))
    result = made(base, config, PinSpline.at(spline.id, aside, spline.span))
    np.testing.assert_allclose(result.snapshot.map[spline.id].curve.control_points, aside.control_points, atol=1e-3)


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (Force(0, 0, 0, 500, 77), "spline 77 is not in the map"),
        (Force(1000, 0, 0, 500, 0), "scan 1000 is no key scan"),
        (Ignore(0, 99, 0, 500), "scan 0 has no segment 99"),
        (MergeSplines(0, 0), "into itself"),
        (SplitSpline(0, (1e3, 1e3), MADE), "so near to its end"),
        (SplitSegment(0, 0, 0), "can be split before beam 0"),
        (DropLoop(0, 5), "no loop closure ties scan 5 to scan 0"),
    ],
)
def test_what_cannot_be_made_is_left_out_and_told(base: Snapshot, config: SlamConfig, edit: Edit, reason: str) -> None:
    result = amended(base, (edit,), config)
    assert result.skipped[0] is not None
    assert reason in result.skipped[0]
    assert largest_move(base, result.snapshot) < 1e-3


def test_an_edit_on_a_spline_whose_making_is_switched_off_is_left_out(
    base: Snapshot, config: SlamConfig, piece: Association
) -> None:
    result = amended(base, (Force(*where(piece), MADE),), config)
    assert result.skipped == (f"spline {MADE} is not in the map",)


def test_a_loop_closed_by_hand_ties_two_key_scans(base: Snapshot, config: SlamConfig) -> None:
    earlier, later = base.steps[0], base.steps[-1]
    measured = se2.between(earlier.pose, later.pose)
    root = tuple(tuple(row) for row in (np.eye(3) / 0.01).tolist())
    x, y, theta = measured.tolist()
    close = CloseLoop(earlier.scan, later.scan, (x, y, theta), root, 0.9, 0.9)  # type: ignore[arg-type]
    result = made(base, config, close).snapshot
    assert result.loop_closures[-1].accepted
    assert len(result.pose_factors) == len(base.pose_factors) + 1
    assert largest_move(base, result) < 1e-3
    back = made(base, config, close, DropLoop(earlier.scan, later.scan)).snapshot
    assert not back.loop_closures[-1].accepted
    assert largest_move(base, back) < 1e-3


def test_a_loop_that_moves_the_map_has_it_built_anew(base: Snapshot, config: SlamConfig) -> None:
    earlier, later = base.steps[0], base.steps[-1]
    x, y, theta = se2.between(earlier.pose, later.pose).tolist()
    root = tuple(tuple(row) for row in (np.eye(3) / 1e-3).tolist())
    close = CloseLoop(earlier.scan, later.scan, (x + 0.5, y, theta), root, 0.9, 0.9)  # type: ignore[arg-type]
    result = made(base, config, close).snapshot
    assert result.map.splines[0].id == base.map.splines[0].id
    assert result.estimate is not None
    assert np.isfinite(result.estimate.chi2)


def test_an_unfinished_map_cannot_be_amended(base: Snapshot, config: SlamConfig) -> None:
    with pytest.raises(SolverError, match="never adjusted"):
        amended(replace(base, estimate=None), (DropLoop(0, 1),), config)


def test_it_can_be_cancelled(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    with pytest.raises(Cancelled):
        amended(base, (Ignore(*where(piece)),), config, cancelled=lambda: True)


def test_a_stopped_run_is_no_ground(config: SlamConfig) -> None:
    slam = Slam(open_log(SAMPLES / "three_splines.log.gz"), config)
    for _, _ in zip(slam.steps(), range(5), strict=False):
        pass
    with pytest.raises(SolverError):
        amended(slam.snapshot(), (DropLoop(0, 1),), config)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.8])
def test_rounds_go_on_while_moves_fall_and_end_when_they_only_wander(share: float) -> None:
    falling = [0.02 * share**k for k in range(60)]
    going = [goes_on(move, before) for before, move in zip(falling, falling[2:], strict=False)]
    assert going == [move > AT_REST for move in falling[2:]]
    wandering = np.random.default_rng(1).uniform(0.0003, 0.0006, 8).tolist()
    assert not all(goes_on(move, before) for before, move in zip(wandering, wandering[2:], strict=False))
    assert goes_on(0.02, np.inf)


def test_a_spline_that_is_drawn_anew_is_pinned_no_longer(base: Snapshot, config: SlamConfig, ground: Ground) -> None:
    spline = base.map.splines[0]
    x, y = spline.curve(np.array([np.mean(spline.span)]))[0].tolist()
    pin, split = PinSpline.at(spline.id, spline.curve, spline.span), SplitSpline(spline.id, (x, y), MADE)
    assert decided(ground, ground.decisions, (pin,))[0].spline_pins.keys() == {spline.id}
    assert not decided(ground, ground.decisions, (pin, split))[0].spline_pins
    result = made(base, config, pin, split)
    pinned, parted = explain(base, result.snapshot, (pin, split), result.skipped, config).outcomes
    assert (pinned.fate, parted.fate) == (Fate.OUTVOTED, Fate.FOLLOWED)


def test_the_published_model_takes_edits_too() -> None:
    config = SlamConfig(model="chord-length")
    base = run_slam(open_log(SAMPLES / "three_splines.log.gz"), config).snapshot
    piece = longest_piece(base)
    result = made(base, config, Ignore(*where(piece)))
    assert [a.spline for a in told(result, piece)] == [None]
    assert largest_move(base, result.snapshot) < 0.1


@pytest.mark.parametrize("name", ["direct", "sam"])
def test_another_back_end_finds_the_same_optimum_of_what_edits_left(
    base: Snapshot, config: SlamConfig, name: str
) -> None:
    piece = longest_piece(base)
    x, y, heading = (base.steps[11].pose + np.array([0.01, 0.0, 0.0])).tolist()
    by_hand = made(base, config, Ignore(*where(piece)), PinPose(piece.scan, (x, y, heading))).snapshot
    again = solved_again(by_hand, name)
    assert [step.associations for step in again.steps] == [step.associations for step in by_hand.steps]
    assert largest_move(by_hand, again) < 1e-5
    assert again.estimate is not None and by_hand.estimate is not None
    assert again.estimate.chi2 == pytest.approx(by_hand.estimate.chi2, rel=1e-6)


def test_only_a_solved_map_can_be_solved_again(base: Snapshot) -> None:
    with pytest.raises(SolverError, match="never adjusted"):
        solved_again(replace(base, estimate=None), "direct")
