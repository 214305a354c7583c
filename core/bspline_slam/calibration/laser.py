"""What all beams of a log have in common that their scans do not tell: when they were taken, and a range bias."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_array

from bspline_slam import se2
from bspline_slam.adjustment.adjust import Foreseen
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.protocol import Estimate
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.fitting import FittingConfig
from bspline_slam.graph import Graph
from bspline_slam.observation import across_sigma
from bspline_slam.sights import find_feet

SURE = 5.0
"""A figure is taken for true when it is so many standard deviations from nothing."""


@dataclass(frozen=True, slots=True)
class LaserCalibration:
    """The first beam of a sweep is taken `sweep` seconds before the last (negative: after it), beams of odd number
    `interlace` seconds after those of even number, and ranges are too long by `offset` (m).

    Each is 0 where the log does not tell it for sure; with the standard deviations that key scans with errors of their
    own leave.
    """

    sweep: float = 0.0
    interlace: float = 0.0
    offset: float = 0.0
    sweep_sigma: float = np.inf
    interlace_sigma: float = np.inf
    offset_sigma: float = np.inf

    @classmethod
    def from_dict(cls, data: Mapping[str, float | None]) -> LaserCalibration:
        """From what `to_dict` made."""
        return cls(**{name: np.inf if value is None else float(value) for name, value in data.items()})

    def to_dict(self) -> dict[str, float | None]:
        """Plain data; a standard deviation that nothing tells is None."""
        return {name: None if np.isinf(value) else round(value, 6) for name, value in asdict(self).items()}

    @property
    def figures(self) -> tuple[float, float, float]:
        """Sweep, interlace (s) and offset (m)."""
        return self.sweep, self.interlace, self.offset

    @property
    def tells(self) -> bool:
        """Whether there is anything to correct."""
        return any(self.figures)


def sweep_share(beams: Int[np.ndarray, "m"], count: int) -> Float[np.ndarray, "m"]:
    """When each beam is taken, in sweeps from the middle of the sweep."""
    return beams / max(count - 1, 1) - 0.5


def oddness(beams: Int[np.ndarray, "m"]) -> Float[np.ndarray, "m"]:
    """½ for beams of odd number, −½ for even ones."""
    return beams % 2 - 0.5


def laser_calibration(
    foreseen: Foreseen,
    outlier: float,
    fitting: FittingConfig,
    beams: int,
    velocities: Float[np.ndarray, "n 3"],
) -> LaserCalibration:
    """Least squares together with all unknowns of the graph, one step of Gauss-Newton from an estimate.

    Beams more than `outlier` standard deviations off count as noisier; `velocities` are those of the key scans, and
    `beams` is how many a scan has. Standard deviations are from the scatter of what is left over, key scan by key scan,
    for the beams of one share errors that the noise of single beams does not tell.
    """
    rows = _Rows.of(foreseen, outlier, fitting)
    columns = rows.columns(foreseen.sights.beam, beams, velocities)
    factor, gradient = _linearised(foreseen.estimate)
    through = rows.jacobian.T @ (rows.weight[:, None] * columns)
    follows = factor.solve(np.column_stack([through, gradient]))
    alone = columns - rows.jacobian @ follows[:, :3]
    normal = columns.T @ (rows.weight[:, None] * alone)
    moment = through.T @ follows[:, 3] - columns.T @ (rows.weight * rows.error)
    left = rows.error - rows.jacobian @ follows[:, 3] + alone @ (np.linalg.pinv(normal) @ moment)
    scores = alone * (rows.weight * left)[:, None]
    scatter = np.stack([np.bincount(rows.pose, score, len(velocities)) for score in scores.T], -1)
    return _sure(normal, moment, scatter.T @ scatter)


def _linearised(estimate: Estimate) -> tuple[Factor, Float[np.ndarray, "u"]]:
    """The factor of the Gauss-Newton matrix at an estimate, and the gradient there."""
    problem = FullProblem.from_graph(estimate.graph)
    linear = problem.linearise(State(estimate.poses, estimate.control_points))
    gradient = linear.blocks.gradient
    return linear.factorise(), np.concatenate([gradient.poses.ravel(), gradient.control_points.ravel()])


def _sure(
    normal: Float[np.ndarray, "3 3"], moment: Float[np.ndarray, "3"], scatter: Float[np.ndarray, "3 3"]
) -> LaserCalibration:
    """The figures that are surely not nothing, the others taken for nothing, the least sure of them first."""
    sigma, value, kept = np.full(3, np.inf), np.zeros(3), np.diag(normal) > 0.0
    while kept.any():
        inverse = np.linalg.pinv(normal[np.ix_(kept, kept)])
        value[:], value[kept] = 0.0, inverse @ moment[kept]
        sigma[kept] = np.sqrt(np.maximum(np.diag(inverse @ scatter[np.ix_(kept, kept)] @ inverse), np.diag(inverse)))
        sure = np.where(kept, np.abs(value) / sigma, np.inf)
        if sure.min() >= SURE:
            break
        kept[np.argmin(sure)] = False
        value[~kept] = 0.0
    return LaserCalibration(*value.tolist(), *sigma.tolist())


@dataclass(frozen=True, eq=False, slots=True)
class _Rows:
    """Beams as rows of the problem near an estimate: `error` is n·(curve − end), `weight` its information (1/m²).

    `seen` are the beams among all sights, `ends` where they should end, `normals` and `directions` in the robot frame.
    `jacobian` has the derivatives of the errors by the unknowns of the graph.
    """

    seen: Int[np.ndarray, "m"]
    pose: Int[np.ndarray, "m"]
    normals: Float[np.ndarray, "m 2"]
    directions: Float[np.ndarray, "m 2"]
    ends: Float[np.ndarray, "m 2"]
    error: Float[np.ndarray, "m"]
    weight: Float[np.ndarray, "m"]
    jacobian: csr_array

    @classmethod
    def of(cls, foreseen: Foreseen, outlier: float, fitting: FittingConfig) -> _Rows:
        """The beams that count on splines of the graph."""
        estimate, sights, graph = foreseen.estimate, foreseen.sights, foreseen.estimate.graph
        feet = find_feet(sights, foreseen.splines, graph.poses, foreseen.gate)
        first = dict(zip(graph.spline_ids.tolist(), graph.spline_first.tolist(), strict=False))
        begin = np.array([first.get(spline.id, -1) for spline in foreseen.splines], dtype=np.int64)[sights.spline]
        seen = np.flatnonzero(feet.counts & (begin >= 0))
        pose, basis = sights.pose[seen], feet.basis[seen]
        normals = se2.rotate(-graph.poses[pose], feet.normals[seen])
        sigma = across_sigma(normals, sights.directions[seen], sights.ranges[seen], fitting)
        sigma = np.maximum(sigma, np.abs(feet.across[seen]) / outlier)
        point = begin[seen, None] + feet.first[seen, None] + np.arange(basis.shape[1])
        point = np.minimum(point, len(graph.control_points) - 1)
        curve = np.einsum("mk,mkd->md", basis, estimate.control_points[point])
        ends = se2.transform(se2.inverse(estimate.poses[pose]), curve)
        across = se2.rotate(estimate.poses[pose], normals)
        return cls(
            seen, pose, normals, sights.directions[seen], ends,
            (normals * (ends - sights.points[seen])).sum(1), sigma**-2.0,
            _jacobian(pose, point, across, -(normals * _turned(ends)).sum(1), basis, graph),
        )  # fmt: skip

    def columns(
        self, beam: Int[np.ndarray, "b"], count: int, velocities: Float[np.ndarray, "n 3"]
    ) -> Float[np.ndarray, "m 3"]:
        """Derivatives of the errors by sweep, interlace and offset."""
        velocity = velocities[self.pose]
        moving = -(self.normals * (velocity[:, :2] + velocity[:, 2:] * _turned(self.ends))).sum(1)
        number = beam[self.seen]
        incidence = (self.normals * self.directions).sum(1)
        return np.column_stack([moving * sweep_share(number, count), moving * oddness(number), incidence])


def _jacobian(
    pose: Int[np.ndarray, "m"],
    point: Int[np.ndarray, "m k"],
    across: Float[np.ndarray, "m 2"],
    by_turn: Float[np.ndarray, "m"],
    basis: Float[np.ndarray, "m k"],
    graph: Graph,
) -> csr_array:
    """Rows of poses (x, y, θ) and of the k control points that each beam hangs on, normals `across` in the world."""
    m, width = len(pose), 3 + 2 * basis.shape[1]
    values, places = np.empty((m, width)), np.empty((m, width), dtype=np.int32)
    values[:, :2], values[:, 2] = -across, by_turn
    places[:, :3] = 3 * pose[:, None] + np.arange(3)
    for axis in range(2):
        values[:, 3 + axis :: 2] = basis * across[:, axis, None]
        places[:, 3 + axis :: 2] = 3 * len(graph.poses) + 2 * point + axis
    begin = np.arange(0, m * width + 1, width, dtype=np.int32)
    return csr_array((values.ravel(), places.ravel(), begin), shape=(m, graph.unknowns))


def _turned(vectors: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m 2"]:
    """Turned left by a right angle."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], -1)
