"""What the explanation says of edits, held against the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.association import Association
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.edits.amend import amended
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.edit import CloseLoop, Edit, Force, Ignore, PinPose
from bspline_slam.edits.explain import KINDS, Explanation, Fate, costs, explain, outcome, rms
from bspline_slam.edits.piece_edits import facing
from bspline_slam.slam import SlamConfig, Snapshot


def explained(base: Snapshot, config: SlamConfig, *edits: Edit) -> Explanation:
    made = amended(base, edits, config)
    return explain(base, made.snapshot, edits, made.skipped, config)


def test_costs_by_kind_are_the_whole_cost(base: Snapshot) -> None:
    estimate = base.estimate
    assert estimate is not None
    found = costs(estimate)
    curves = pack_curves(estimate.graph).cost(estimate.poses, estimate.control_points)
    edges = pack_edges(estimate.graph).cost(estimate.poses)[0]
    constant = sum(factor.constant for factor in estimate.graph.spline_factors)
    assert tuple(found) == KINDS
    assert sum(found.values()) == pytest.approx(0.5 * (curves + edges + constant))
    assert all(value >= 0 for value in found.values())


def test_the_ten_worst_are_in_order_and_lead_somewhere(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    found = explained(base, config, Ignore(piece.scan, piece.segment, piece.first, piece.last))
    assert len(found.worst) == 10
    assert [worst.size for worst in found.worst] == sorted((worst.size for worst in found.worst), reverse=True)
    scans = {step.scan for step in base.steps}
    for worst in found.worst:
        assert worst.scan in scans
        assert (worst.segment is None) == (worst.spline is None) == (worst.other is not None)


def test_a_forced_piece_nearby_is_followed_and_one_far_off_outvoted(
    base: Snapshot, config: SlamConfig, piece: Association
) -> None:
    where = (piece.scan, piece.segment, piece.first, piece.last)
    assert piece.spline is not None
    other = next(spline.id for spline in base.map if spline.id != piece.spline)
    near = explained(base, config, Force(*where, piece.spline)).outcomes[0]
    far = explained(base, config, Force(*where, other)).outcomes[0]
    assert (near.fate, far.fate) == (Fate.FOLLOWED, Fate.OUTVOTED)
    assert near.weight is not None and far.weight is not None
    assert near.weight > 0.9 > 0.1 > far.weight


def test_what_is_left_out_says_why(base: Snapshot, config: SlamConfig) -> None:
    found = explained(base, config, Ignore(99999, 0, 0, 1)).outcomes[0]
    assert (found.fate, found.sentence) == (Fate.SKIPPED, "Scan 99999 is no key scan.")


def test_a_pin_is_followed_and_moves_are_told(base: Snapshot, config: SlamConfig) -> None:
    pose = se2.compose(base.steps[5].pose, np.array([0.02, 0.0, 0.0]))
    found = explained(base, config, PinPose(base.steps[5].scan, tuple(pose.tolist())))
    assert found.outcomes[0].fate is Fate.FOLLOWED
    assert found.moves[5] == pytest.approx(0.02, abs=1e-3)
    assert found.after["pins"] >= 0


@pytest.mark.parametrize(("off", "fate"), [(0.0, Fate.FOLLOWED), (0.08, Fate.OUTVOTED)])
def test_a_closure_is_followed_or_outvoted(base: Snapshot, config: SlamConfig, off: float, fate: Fate) -> None:
    x, y, turn = se2.between(base.steps[0].pose, base.steps[-1].pose).tolist()
    root = ((100.0, 0.0, 0.0), (0.0, 100.0, 0.0), (0.0, 0.0, 100.0))
    close = CloseLoop(base.steps[0].scan, base.steps[-1].scan, (x + off, y, turn), root, 0.9, 0.9)
    assert explained(base, config, close).outcomes[0].fate is fate


def test_beams_that_see_a_spline_from_behind_say_nothing(
    base: Snapshot, config: SlamConfig, piece: Association
) -> None:
    assert piece.spline is not None
    spline, where = base.map[piece.spline], (piece.scan, piece.segment, piece.first, piece.last)
    low, high = (spline.curve.knots[0] + spline.curve.knots[-1] - end for end in reversed(spline.span))
    turned = replace(spline, id=max(s.id for s in base.map) + 1, curve=spline.curve.reversed(), span=(low, high))
    decisions = Decisions.of(base).with_spline(turned)
    seen = facing(decisions, Force(*where, spline.id))
    assert len(seen) > 0.9 * (piece.last - piece.first)
    assert rms(seen) == pytest.approx(piece.distance, rel=0.2)
    assert len(facing(decisions, Force(*where, turned.id))) == 0
    made = outcome(Force(*where, turned.id), decisions, config)
    assert (made.fate, made.weight) == (Fate.OUTVOTED, 0.0)


def test_beams_that_count_no_more_are_told(base: Snapshot, config: SlamConfig, piece: Association) -> None:
    """What is ignored costs nothing, so the cost falls, and the count says why."""
    found = explained(base, config, Ignore(piece.scan, piece.segment, piece.first, piece.last))
    before, after = found.beams
    assert 0 < before - after <= piece.last - piece.first + 1
    assert found.after["beams on curves"] < found.before["beams on curves"]
