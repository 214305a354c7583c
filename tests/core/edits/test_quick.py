"""The quick answer against the exact one."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.association import Association
from bspline_slam.backends import back_end
from bspline_slam.backends.protocol import Estimate
from bspline_slam.edits.amend import amended
from bspline_slam.edits.edit import (
    FIRST_MADE_BY_HAND,
    CloseLoop,
    Edit,
    Forbid,
    Force,
    Ignore,
    MakeNew,
    MergeSplines,
    PinPose,
    PinSpline,
    SplitSpline,
)
from bspline_slam.edits.explain import costs
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.making import decided
from bspline_slam.edits.problem import Changes, Problem, linearised
from bspline_slam.edits.quick import Answer, Footing, answer
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot

MADE = FIRST_MADE_BY_HAND


@pytest.fixture(scope="module")
def footing(ground: Ground) -> Footing:
    return Footing.of(ground)


def edits_of(base: Snapshot, piece: Association) -> dict[str, tuple[Edit, ...]]:
    where = (piece.scan, piece.segment, piece.first, piece.last)
    assert piece.spline is not None
    spline = base.map[piece.spline]
    x, y = spline.curve(np.array([np.mean(spline.span)]))[0].tolist()
    pose = se2.compose(base.steps[5].pose, np.array([0.01, 0.0, 0.002])).tolist()
    tie = se2.between(base.steps[0].pose, base.steps[-1].pose).tolist()
    root = ((50.0, 0.0, 0.0), (0.0, 50.0, 0.0), (0.0, 0.0, 200.0))
    split = SplitSpline(spline.id, (x, y), MADE)
    return {
        "ignore": (Ignore(*where),),
        "forbid": (Forbid(*where, piece.spline),),
        "force": (Force(*where, piece.spline),),
        "new": (MakeNew(*where, MADE),),
        "split": (split,),
        "split and merge": (split, MergeSplines(spline.id, MADE)),
        "pin pose": (PinPose(base.steps[5].scan, tuple(pose)),),
        "pin spline": (PinSpline.at(spline.id, spline.curve, spline.span),),
        "loop": (CloseLoop(base.steps[0].scan, base.steps[-1].scan, tuple(tie), root, 0.9, 0.9),),
    }


def standard_deviations(exact: Estimate, poses: np.ndarray) -> list[float]:
    """How many of its own standard deviations each pose but the first, which is held, lies from the exact one."""
    numbers = range(1, len(poses))
    covariances = back_end("direct").covariances(exact, poses=numbers).poses
    off = poses - exact.poses
    return [float(np.sqrt(off[k] @ np.linalg.solve(covariances[k], off[k]))) for k in numbers]


@pytest.mark.parametrize("kind", ["ignore", "forbid", "new", "split", "pin pose", "pin spline", "loop"])
def test_the_quick_answer_is_the_optimum_of_the_exchanged_problem(
    base: Snapshot, piece: Association, ground: Ground, footing: Footing, kind: str
) -> None:
    told: list[Answer] = []
    decisions, skipped = decided(ground, ground.decisions, edits_of(base, piece)[kind])
    assert skipped == (None,)
    quick = answer(footing, decisions, told.append)
    assert told[-1] is quick
    assert quick.at_rest
    changes = Changes.of(ground, decisions)
    problem = Problem.of(ground, decisions, changes, linearised(ground, decisions, changes))
    exact = back_end("direct").solve(problem.graph)
    assert max(standard_deviations(exact, quick.decisions.poses)) < 0.1
    change = sum(costs(exact).values()) - sum(costs(ground.estimate).values())
    assert quick.cost_change == pytest.approx(change, abs=4.0)  # gauges of curves drawn anew are no longer there


@pytest.mark.parametrize("kind", ["force", "split and merge"])
def test_what_a_person_holds_comes_near_the_exact_result(
    base: Snapshot, config: SlamConfig, piece: Association, ground: Ground, footing: Footing, kind: str
) -> None:
    edits = edits_of(base, piece)[kind]
    quick = answer(footing, decided(ground, ground.decisions, edits)[0])
    exact = amended(base, edits, config)
    after = np.array([step.pose for step in exact.snapshot.steps])
    np.testing.assert_allclose(quick.decisions.poses, after, atol=0.02)
    assert {s.id for s in exact.snapshot.map} <= {s.id for s in quick.decisions.splines}


def test_what_says_less_costs_less_and_a_pin_elsewhere_costs_more(
    base: Snapshot, piece: Association, ground: Ground, footing: Footing
) -> None:
    edits = edits_of(base, piece)
    change = {
        kind: answer(footing, decided(ground, ground.decisions, edits[kind])[0]).cost_change
        for kind in ("ignore", "pin pose")
    }
    assert change["ignore"] < 0 < change["pin pose"]


def test_nothing_changed_is_at_rest_at_once(ground: Ground, footing: Footing) -> None:
    found = answer(footing, ground.decisions)
    assert (found.rounds, found.at_rest) == (1, True)
    assert found.largest_move < 1e-6
    assert abs(found.cost_change) < 1e-6
