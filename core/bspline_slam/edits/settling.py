"""From decisions that edits made to the optimum of the problem that they leave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam.adjustment.adjust import with_control_points
from bspline_slam.backends import Stopping
from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import State, descend
from bspline_slam.backends.protocol import Cancelling, IterationRecord, never, silent
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.problem import Changes, Problem, held_by_hand, linearised
from bspline_slam.errors import Cancelled
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
) -> Ground:
    """Solve, and linearise what is loose anew, until nothing moves: the ground at the optimum.

    Loose are beams that a person holds to a spline, and what has moved far since it was linearised.
    """
    changes = Changes.of(ground, decisions)
    held, moves, number = held_by_hand(decisions, changes), (np.inf, np.inf), 0
    while True:
        if cancelled():
            raise Cancelled("the edits were cancelled")

        def note(record: IterationRecord, number: int = number) -> None:
            progress("edits", (number + min(record.index, 4) / 5) / MOST_ROUNDS, record)

        problem = Problem.of(ground, decisions, changes, linearised(ground, decisions, changes))
        check_anchored(problem.graph)
        full, before = FullProblem.from_graph(problem.graph), decisions.poses
        state = descend(full, State(before, problem.graph.control_points), WARM, note, cancelled).state
        decisions, number = _at(decisions, problem.graph, state), number + 1
        move, more = float(np.abs(state.poses - before).max()), problem.moved_units(state)
        if number == MOST_ROUNDS or not goes_on(move, moves[0]) or not (held or more):
            break
        changes, moves = changes.with_units(more), (moves[1], move)
    descent = descend(full, state, Stopping(), silent, cancelled)
    estimate = estimate_of(problem.graph, full.curves, full.edges, descent)
    decisions = _at(decisions, problem.graph, descent.state)
    return replace(ground, decisions=decisions, estimate=estimate, seen=problem.seen)


def goes_on(move: float, before: float) -> bool:
    """Whether rounds still lead somewhere: key poses moved by `move` in the last and by `before` two rounds earlier."""
    return AT_REST < move < FALLING * before


def _at(decisions: Decisions, graph: Graph, state: State) -> Decisions:
    """The decisions with the poses and curves of a state; splines that are not in the graph are gone."""
    splines = with_control_points(decisions.splines, graph, state.control_points)
    return replace(decisions, poses=state.poses, splines=splines)
