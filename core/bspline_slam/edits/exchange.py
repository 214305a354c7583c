"""The factors that edits take out of a problem and those that they put in, as rows of its linear system."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_array

from bspline_slam import se2
from bspline_slam.backends.statistics import measures
from bspline_slam.edits.decisions import Decisions
from bspline_slam.edits.ground import Ground
from bspline_slam.edits.loop_edits import pins
from bspline_slam.edits.problem import Changes, linearised, on_splines, pinned, pose_factors
from bspline_slam.graph import Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor

Term = SplineFactor | ShapePrior | PoseFactor | PosePrior
Unknowns = tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "N 2"]]
"""Poses, and all control points: those of the problem, then those of splines that edits drew."""
Block = tuple[int, Float[np.ndarray, "r _"]]
"""The first column of a block of a Jacobian, and the block."""


@dataclass(frozen=True, eq=False, slots=True)
class Exchanged:
    """A term with its sign, +1 put in and −1 taken out, and the first control point that it is about."""

    term: Term
    sign: float
    first: int = 0

    def linearised(
        self, unknowns: Unknowns
    ) -> tuple[list[tuple[int, Float[np.ndarray, "r _"]]], Float[np.ndarray, "r"]]:
        """The derivatives by the unknowns, and the whitened residual, both with the weight of its robust kernel."""
        poses, points = unknowns
        match self.term:
            case SplineFactor(pose=pose, A=A) as term:
                mine = points[self.first : self.first + A.shape[1] // 2]
                by_pose, by_points = term.jacobians(poses[pose], mine)
                blocks = [(3 * pose, by_pose), (3 * len(poses) + 2 * self.first, by_points)]
                return blocks, term.residual(poses[pose], mine)
            case ShapePrior(A=A) as term:
                mine = points[self.first : self.first + A.shape[1] // 2]
                return [(3 * len(poses) + 2 * self.first, A)], term.residual(mine)
            case PoseFactor(i=i, j=j) as term:
                residual = term.residual(poses[i], poses[j])
                weight = np.sqrt(robust_weight(residual, term.kernel))
                by_i, by_j = term.jacobians(poses[i], poses[j])
                return [(3 * i, weight * by_i), (3 * j, weight * by_j)], weight * residual
            case PosePrior(pose=pose) as term:
                return [(3 * pose, term.sqrt_information)], term.residual(poses[pose])

    def cost(self, unknowns: Unknowns) -> float:
        """± ½ρ(‖e‖²), with what no state can remove."""
        poses, points = unknowns
        match self.term:
            case SplineFactor(pose=pose, A=A) as term:
                residual = term.residual(poses[pose], points[self.first : self.first + A.shape[1] // 2])
                return 0.5 * self.sign * float(residual @ residual + term.constant)
            case PoseFactor(i=i, j=j, kernel=kernel) as term:
                residual = term.residual(poses[i], poses[j])
                square = float(residual @ residual)
                return 0.5 * self.sign * (square if kernel is None else kernel**2 * np.log1p(square / kernel**2))
            case _:
                residual = self.linearised(unknowns)[1]
                return 0.5 * self.sign * float(residual @ residual)

    def bent(self, unknowns: Unknowns) -> list[tuple[int, int, float]]:
        """What Newton's matrix of an observation has beyond that of Gauss and Newton: row, column and value of the
        entries on and below the diagonal of its pose, and of its points with its heading."""
        poses, points = unknowns
        if not isinstance(self.term, SplineFactor):
            return []
        pose, mine = poses[self.term.pose], points[self.first : self.first + self.term.A.shape[1] // 2]
        turn = se2.rotation(pose[2])
        g = (self.term.A.T @ self.term.residual(pose, mine)).reshape(-1, 2)
        u = np.stack([-g[:, 1], g[:, 0]], -1) @ turn.T
        q = (mine - pose[:2]) @ turn
        heading, at = 3 * self.term.pose + 2, 3 * len(poses) + 2 * self.first
        out = [(at + k, heading, float(value)) for k, value in enumerate(u.ravel())]
        out += [(heading, heading - 2 + k, -float(value)) for k, value in enumerate(u.sum(0))]
        return [*out, (heading, heading, -float((g * q).sum()))]


@dataclass(frozen=True, eq=False, slots=True)
class Exchange:
    """Exchanged terms as a linear system: what they add to the gradient of the cost and to Newton's matrix."""

    gradient: Float[np.ndarray, "u"]
    matrix: csr_array

    @classmethod
    def of(cls, exchanged: Sequence[Exchanged], unknowns: Unknowns) -> Exchange:
        """Linearised at these unknowns."""
        count = 3 * len(unknowns[0]) + 2 * len(unknowns[1])
        entries, residuals, signs, bends, row = [], [], [], [], 0
        for one in exchanged:
            blocks, residual = one.linearised(unknowns)
            for column, block in blocks:
                r, c = np.indices(block.shape)
                entries.append((block.ravel(), row + r.ravel(), column + c.ravel()))
            bends += [(r, c, one.sign * value) for r, c, value in one.bent(unknowns)]
            residuals.append(residual)
            signs.append(np.full(len(residual), one.sign))
            row += len(residual)
        values, rows, columns = (
            np.concatenate([np.zeros(0), *part]) for part in zip(*entries, ((), (), ()), strict=True)
        )
        J = csr_array((values, (rows.astype(np.int64), columns.astype(np.int64))), shape=(row, count))
        sign = np.concatenate([np.zeros(0), *signs])
        gradient = J.T @ (sign * np.concatenate([np.zeros(0), *residuals]))
        return cls(gradient, csr_array(J.T @ (J * sign[:, None]) + _symmetric(bends, count)))


def robust_weight(residual: Float[np.ndarray, "r"], kernel: float | None) -> float:
    """What a Cauchy kernel leaves of the weight of a whitened residual."""
    return 1.0 if kernel is None else float(1.0 / (1.0 + residual @ residual / kernel**2))


def _symmetric(lower: Sequence[tuple[int, int, float]], count: int) -> csr_array:
    """The symmetric matrix of entries on one side of the diagonal."""
    r, c, value = np.array(lower).reshape(-1, 3).T
    r, c = r.astype(np.int64), c.astype(np.int64)
    off = r != c
    both = (np.concatenate([value, value[off]]), (np.append(r, c[off]), np.append(c, r[off])))
    return csr_array(both, shape=(count, count))


def taken_out(
    ground: Ground, decisions: Decisions, changes: Changes, measuring: Mapping[int, Sequence[int]]
) -> list[Exchanged]:
    """The terms of the ground's problem that edits make void; `measuring` are the numbers of the factors that measure
    each spline."""
    graph = ground.estimate.graph
    splines = changes.drawn | {spline for _, spline in changes.units}
    out = []
    for spline in sorted(splines & measuring.keys()):
        for k in measuring[spline]:
            factor = graph.spline_factors[k]
            if spline in changes.drawn or (factor.pose, spline) in changes.units:
                out.append(Exchanged(factor, -1.0, factor.first))
    kept = set(map(id, pose_factors(ground, decisions)))
    out.extend(Exchanged(factor, -1.0) for factor in graph.pose_factors if id(factor) not in kept)
    return out


def put_in(ground: Ground, decisions: Decisions, changes: Changes, places: Mapping[int, int]) -> list[Exchanged]:
    """The terms that edits bring in, linearised where the decisions are; `places` tell where each spline begins among
    all control points."""
    graph, new = ground.estimate.graph, linearised(ground, decisions, changes)
    out = [Exchanged(term, 1.0, first) for first, term in _placed(new, changes, places)]
    known = ground.decisions.spline_pins
    fresh = {s: c for s, c in decisions.spline_pins.items() if s in changes.drawn or c is not known.get(s)}
    out += [Exchanged(prior, 1.0, prior.first) for prior in pinned(replace(decisions, spline_pins=fresh), places)]
    there = set(map(id, graph.pose_factors))
    out += [Exchanged(factor, 1.0) for factor in pose_factors(ground, decisions) if id(factor) not in there]
    held = {prior.pose for prior in graph.pose_priors[1:]}
    adjustment = ground.config.adjustment
    out += [Exchanged(prior, 1.0) for prior in pins(decisions, adjustment.anchor) if prior.pose not in held]
    return out


def _placed(new: Graph, changes: Changes, places: Mapping[int, int]) -> Iterator[tuple[int, Term]]:
    for spline, local, factor in on_splines(new, new.spline_factors):
        if measures(factor) or spline in changes.drawn:
            yield places[spline] + local, factor
    for spline, local, prior in on_splines(new, new.shape_priors):
        if spline in changes.drawn:
            yield places[spline] + local, prior
