"""The way to the optimum by one factor, against Newton's own steps; the gradient, against differences of the cost."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.backends import Stopping, back_end
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.protocol import never
from bspline_slam.edits.descent import Packed, descended
from bspline_slam.edits.ground import Ground
from bspline_slam.errors import Cancelled


def start_at(ground: Ground, sigma: float) -> State:
    """The optimum, disturbed; the first pose, which is held, stays."""
    rng, estimate = np.random.default_rng(3), ground.estimate
    poses = estimate.poses + rng.normal(0.0, sigma, estimate.poses.shape)
    poses[0] = estimate.poses[0]
    return State(poses, estimate.control_points + rng.normal(0.0, sigma, estimate.control_points.shape))


@pytest.mark.parametrize("sigma", [1e-4, 3e-3, 3e-2])
def test_every_start_leads_to_the_optimum(ground: Ground, sigma: float) -> None:
    problem, start = Packed.of(ground.estimate.graph), start_at(ground, sigma)
    best = back_end("direct").solve(ground.estimate.graph)
    found, factor = descended(problem, None, start, Stopping(), never)
    assert found.converged
    np.testing.assert_allclose(found.state.poses, best.poses, atol=1e-5)
    assert found.records[-1].cost == pytest.approx(best.iterations[-1].cost, rel=1e-7)
    again, same = descended(problem, factor, found.state, Stopping(), never)
    assert same is factor
    np.testing.assert_allclose(again.state.poses, found.state.poses, atol=1e-6)


def test_a_factor_from_elsewhere_is_made_anew(ground: Ground) -> None:
    problem = Packed.of(ground.estimate.graph)
    far = start_at(ground, 0.3)
    stale = problem.analysed(far).linearise(far).factorise(1e9)
    found, factor = descended(problem, stale, start_at(ground, 1e-3), Stopping(), never)
    assert found.converged and factor is not stale
    best = back_end("direct").solve(ground.estimate.graph)
    np.testing.assert_allclose(found.state.poses, best.poses, atol=1e-5)


def test_the_gradient_is_that_of_the_cost(ground: Ground) -> None:
    problem, state = Packed.of(ground.estimate.graph), start_at(ground, 1e-3)
    gradient, rng, step = problem.gradient(state), np.random.default_rng(0), 1e-6
    for _ in range(5):
        way = State(rng.normal(size=state.poses.shape), rng.normal(size=state.control_points.shape))
        ahead = State(state.poses + step * way.poses, state.control_points + step * way.control_points)
        behind = State(state.poses - step * way.poses, state.control_points - step * way.control_points)
        slope = (problem.cost(ahead) - problem.cost(behind)) / (2 * step)
        told = float((gradient.poses * way.poses).sum() + (gradient.control_points * way.control_points).sum())
        assert told == pytest.approx(slope, rel=1e-4)


def test_it_can_be_cancelled(ground: Ground) -> None:
    with pytest.raises(Cancelled):
        descended(Packed.of(ground.estimate.graph), None, start_at(ground, 1e-3), Stopping(), lambda: True)
