"""From decisions that edits made to the optimum of the problem that they leave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.adjustment.adjust import with_control_points
from bspline_slam.backends import Stopping
from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.protocol import Cancelling, never
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.corners import corners_of, meeting
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.descent import Packed, descended
from bspline_slam.edits.footing import Footing
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.problem import Changes, Problem, held_by_hand, linearised
from bspline_slam.graph import Graph
from bspline_slam.slam import StageProgress, quiet

MOST_ROUNDS = 10
AT_REST = 1e-4
"""Rounds end when none of the key poses moves by more than this (m, rad), or when the moves no longer fall."""
FALLING = 0.75
"""The largest move of a key pose falls to less than this share of it within two rounds, or it no longer falls: where
beams enter and leave the gate of a curve that slides along itself, each round would move a little for ever."""
WARM = Stopping(decrease=1e-7, move=1e-5, iterations=20)
"""Rounds before the last."""


def settled(
    ground: Ground, decisions: Decisions, progress: StageProgress = quiet, cancelled: Cancelling = never
) -> Footing:
    """Solve, and linearise what is loose anew, until nothing moves: the footing at the optimum.

    Loose are beams that a person holds to a spline, and what has moved far since it was linearised.
    """
    changes = Changes.of(ground, decisions)
    joints = {corner.joint for each in (ground.decisions, decisions) for corner in corners_of(each.splines)}
    held, moves, number, factor, layout = held_by_hand(decisions, changes), (np.inf, np.inf), 0, None, None
    while True:
        progress("edits", number / MOST_ROUNDS, None)
        problem = Problem.of(ground, decisions, changes, linearised(ground, decisions, changes))
        check_anchored(problem.graph)
        packed, start = Packed.of(problem.graph), State(decisions.poses, problem.graph.control_points)
        before, layout = layout, (problem.graph.spline_ids.tolist(), problem.graph.spline_first.tolist())
        descent, factor = descended(packed, factor if layout == before else None, start, WARM, cancelled)
        decisions, number = _at(decisions, problem.graph, descent.state), number + 1
        move, more = _move(start, descent.state), problem.moved_units(packed.curves, descent.state)
        if number == MOST_ROUNDS or not goes_on(move, moves[0]) or not (held or more):
            break
        changes, moves = changes.with_units(more), (moves[1], move)
    descent, factor = descended(packed, factor, descent.state, Stopping(), cancelled)
    estimate = estimate_of(problem.graph, packed.curves, packed.edges, descent)
    decisions = _at(decisions, problem.graph, descent.state)
    decisions = replace(decisions, splines=meeting(decisions.splines, sorted(joints)))
    ground = replace(ground, decisions=decisions, estimate=estimate, seen=problem.seen)
    return Footing(ground, packed, descent.state, descent.records[-1].cost, factor)


def _move(before: State, after: State) -> float:
    """By how much (m, rad) a pose moved most."""
    step = after.poses - before.poses
    step[:, 2] = se2.wrap(step[:, 2])
    return float(np.abs(step).max(initial=0.0))


def goes_on(move: float, before: float) -> bool:
    """Whether rounds still lead somewhere: key poses moved by `move` in the last and by `before` two rounds earlier."""
    return AT_REST < move < FALLING * before


def _at(decisions: Decisions, graph: Graph, state: State) -> Decisions:
    """The decisions with the poses and curves of a state; splines that are not in the graph are gone."""
    splines = with_control_points(decisions.splines, graph, state.control_points)
    return replace(decisions, poses=state.poses, splines=splines)
