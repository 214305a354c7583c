"""The quick answer: what an edit does to the map, in a few hundredths of a second.

The Cholesky factor H of the problem that was solved last is kept. An edit takes some factors out of the problem and
puts others in: (H + Δ) x = −g, with a Δ of low rank, is solved by conjugate gradients preconditioned with H, which
takes about as many steps as Δ has ranks. Since H z = r is what the preconditioner solved, H times a search direction
follows from the residuals, and H itself is never needed. New control points are eliminated first, as one block. And
so on from there until the map rests.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array

from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.exchange import Terms, put_in, taken_out
from bspline_slam.edits.footing import Footing
from bspline_slam.edits.problem import Changes, held_by_hand
from bspline_slam.spline_map import SplineMap

MOST_ROUNDS = 6
AT_REST = 2e-4
"""Rounds end when no pose moves by more than this (m, rad), or would not in the next one, if moves go on falling."""
CLIMB = 1.0
"""A round whose change of the cost is worse than that of the one before by this share (and by 1) is taken back."""
MOST_STEPS = 60
ENOUGH_STEPS = 40
"""No more rounds begin after so many steps: the exact answer is as near."""
ACCURATE = 5e-3
"""Conjugate gradients end when the preconditioned residual has fallen to this share of the first one: what is left of
it is there for the next round."""
UNMOVED = 1e-6
"""Curves whose control points moved by less than this (m) stay as they are."""


@dataclass(frozen=True, eq=False, slots=True)
class Answer:
    """Where edits take the map: the decisions there, how much the cost ½Σρ changes, and by what effort.

    `largest_move` is that of a key pose (m). `at_rest` says whether the map would stay there.
    """

    decisions: Decisions
    cost_change: float
    largest_move: float
    rounds: int
    steps: int
    at_rest: bool


def answer(
    footing: Footing,
    decisions: Decisions,
    tell: Callable[[Answer], None] = lambda _: None,
    rounds: int = MOST_ROUNDS,
) -> Answer:
    """The quick answer to decisions that differ from those of the footing, in so many rounds; `tell` is called with it
    after each round, the first time as soon as there is one."""
    ground, start = footing.ground, footing.state
    changes = Changes.of(ground, decisions)
    places, drawn = _places(footing, decisions, changes)
    curves = [decisions.splines[spline].curve.control_points for spline in drawn]
    here = State(start.poses, np.concatenate([start.control_points, *curves]))
    old, count = len(start.control_points), len(here.control_points)
    before = taken_out(ground, footing.problem, decisions, changes, count)
    after = put_in(ground, decisions, changes, places, count)
    steps, number, at_rest, before_move = 0, 0, False, 0.0
    held, void = held_by_hand(decisions, changes), before.linearised(here).matrix
    found: Answer | None = None
    while not at_rest and number < rounds and steps < ENOUGH_STEPS:
        number += 1
        after = put_in(ground, decisions, changes, places, count) if held and number > 1 else after
        x, taken = _direction(footing, before, after, void, here)
        here, steps = _moved(here, x), steps + taken
        decisions = _at(decisions, here, places)
        move = float(np.abs(x[: start.poses.size]).max(initial=0.0))
        at_rest, before_move = _rests(move, before_move), move
        state = State(here.poses, here.control_points[:old])
        change = footing.problem.cost(state) - before.cost(here) + after.cost(here) - footing.cost
        if found is not None and change > found.cost_change + CLIMB * (1.0 + abs(found.cost_change)):
            return found
        farthest = float(np.linalg.norm((here.poses - start.poses)[:, :2], axis=1).max(initial=0.0))
        found = Answer(decisions, float(change), farthest, number, steps, at_rest)
        tell(found)
    assert found is not None
    return found


def _direction(
    footing: Footing, before: Terms, after: Terms, void: csr_array, here: State
) -> tuple[Float[np.ndarray, "u"], int]:
    """The step over all unknowns where the terms `before`, whose matrix is `void`, have given way to those `after`, and
    how many steps of conjugate gradients it took. Where the matrix of Newton leads nowhere that of Gauss and Newton
    does."""
    old = footing.unknowns
    out = before.linearised(here).gradient
    out[:old] -= footing.gradient_at(State(here.poses, here.control_points[: len(footing.state.control_points)]))
    brought = after.linearised(here)
    x, taken = _solved(footing.factor, csr_array(brought.matrix - void), brought.gradient - out, old)
    if not taken:
        brought = after.linearised(here, convex=True)
        x, taken = _solved(footing.factor, csr_array(brought.matrix - void), brought.gradient - out, old)
    return x, taken


def _rests(move: float, before: float) -> bool:
    """Whether the next round would move no pose, the moves falling as they did from `before` to `move` (0: unknown)."""
    return move < AT_REST or (move < before and move * move / before < AT_REST)


def _places(footing: Footing, decisions: Decisions, changes: Changes) -> tuple[dict[int, int], list[int]]:
    """Where each spline begins among all control points, and the drawn ones in their order there."""
    graph = footing.ground.estimate.graph
    places = dict(zip(graph.spline_ids.tolist(), graph.spline_first.tolist(), strict=False))
    drawn, end = sorted(changes.drawn), len(footing.state.control_points)
    for spline in drawn:
        places[spline] = end
        end += len(decisions.splines[spline].curve.control_points)
    return places, drawn


def _moved(state: State, x: Float[np.ndarray, "u"]) -> State:
    """The state after a step, angles wrapped."""
    split = state.poses.size
    return state.moved(State(x[:split].reshape(-1, 3), x[split:].reshape(-1, 2)))


def _at(decisions: Decisions, state: State, places: Mapping[int, int]) -> Decisions:
    """The decisions with these poses and curves."""
    splines = []
    for spline in decisions.splines:
        first, was = places[spline.id], spline.curve.control_points
        now = state.control_points[first : first + len(was)]
        still = np.abs(now - was).max() < UNMOVED
        splines.append(spline if still else replace(spline, curve=spline.curve.with_control_points(now)))
    return replace(decisions, poses=state.poses, splines=SplineMap(tuple(splines)))


def _solved(
    factor: Factor, change: csr_array, gradient: Float[np.ndarray, "u"], old: int
) -> tuple[Float[np.ndarray, "u"], int]:
    """(H + Δ) x = −g over all unknowns, and how many steps of conjugate gradients it took; H knows the `old` first."""
    g, h = gradient[:old], gradient[old:]
    inner = change[:old, :old]
    if len(h) == 0:
        return _conjugate_gradients(factor, lambda v: inner @ v, -g)
    across = change[:old, old:]
    eliminated = cho_factor(change[old:, old:].toarray() + STEP_INFORMATION * np.eye(len(h)))

    def without_new(v: Float[np.ndarray, "o"]) -> Float[np.ndarray, "o"]:
        return inner @ v - across @ cho_solve(eliminated, across.T @ v)

    x, steps = _conjugate_gradients(factor, without_new, across @ cho_solve(eliminated, h) - g)
    return np.concatenate([x, -cho_solve(eliminated, h + across.T @ x)]), steps


def _conjugate_gradients(
    factor: Factor, change: Callable[[Float[np.ndarray, "o"]], Float[np.ndarray, "o"]], right: Float[np.ndarray, "o"]
) -> tuple[Float[np.ndarray, "o"], int]:
    """(H + Δ) x = right, preconditioned with H: H times the direction p goes along with p."""
    x, r = np.zeros_like(right), right
    z = factor.solve(r[:, None])[:, 0]
    p, Hp, rz = z, r, float(r @ z)
    enough = ACCURATE**2 * rz
    for step in range(1, MOST_STEPS + 1):
        q = Hp + change(p)
        curvature = float(p @ q)
        if rz <= enough or curvature <= 0.0:
            return x, step - 1
        x, r = x + rz / curvature * p, r - rz / curvature * q
        z = factor.solve(r[:, None])[:, 0]
        before, rz = rz, float(r @ z)
        p, Hp = z + rz / before * p, r + rz / before * Hp
    return x, MOST_STEPS
