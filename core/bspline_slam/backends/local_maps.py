"""Local maps: what is known in the frame of a pose about other poses and about points, in information form.

Each is one observation of the joint state (Huang et al. 2008, I-SLSJF): with h(X) the poses and points of a map as
they lie in its frame, e = W·(h(X) ⊖ z) − b, whitened. W may have no full rank, so a map may leave directions open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu

from bspline_slam import se2
from bspline_slam.backends.gauss_newton import State
from bspline_slam.errors import SolverError

WORLD = -1
"""The frame of what is stated in the world itself."""


@dataclass(frozen=True, eq=False, slots=True)
class Statement:
    """One whitened statement: h holds the poses (x, y, θ), then the points (x, y), all in frame `frame`.

    `kernel` is the width of a Cauchy kernel, inf for none; only statements on one pose alone may have one.
    """

    frame: int
    poses: Int[np.ndarray, "p"]
    points: Int[np.ndarray, "m"]
    W: Float[np.ndarray, "r d"]
    z: Float[np.ndarray, "d"]
    b: Float[np.ndarray, "r"]
    kernel: float = np.inf


@dataclass(frozen=True, eq=False, slots=True)
class LocalMaps:
    """Local maps one after another, flat. Rows of h are those of W's columns.

    Pose k of the list is `pose[k]` in frame `pose_frame[k]` and fills three rows of h from `pose_row[k]`, with a
    Cauchy kernel of width `kernel[k]` on the residuals from `kernel_row[k]`; a point fills two rows. `begin[i]`
    says where map i begins among poses, points, rows of h, and residuals. `hold` is the information that holds each
    step where maps leave directions open.
    """

    pose: Int[np.ndarray, "p"]
    pose_frame: Int[np.ndarray, "p"]
    pose_row: Int[np.ndarray, "p"]
    kernel: Float[np.ndarray, "p"]
    kernel_row: Int[np.ndarray, "p"]
    point: Int[np.ndarray, "q"]
    point_frame: Int[np.ndarray, "q"]
    point_row: Int[np.ndarray, "q"]
    W: csr_array
    gram: csr_array
    z: Float[np.ndarray, "d"]
    b: Float[np.ndarray, "r"]
    begin: Int[np.ndarray, "k1 4"]
    hold: float

    @classmethod
    def from_statements(cls, maps: Sequence[Sequence[Statement]], hold: float = 0.0) -> LocalMaps:
        """The maps, each a list of statements; those that leave directions open need an information to `hold` steps."""
        flat = [statement for one in maps for statement in one]
        poses = np.array([len(statement.poses) for statement in flat], dtype=np.int64)
        points = np.array([len(statement.points) for statement in flat], dtype=np.int64)
        residuals = np.array([len(statement.b) for statement in flat], dtype=np.int64)
        sizes = np.column_stack([poses, points, 3 * poses + 2 * points, residuals]).reshape(-1, 4)
        begins = np.vstack([np.zeros((1, 4), np.int64), np.cumsum(sizes, axis=0)])
        frames = np.array([statement.frame for statement in flat], dtype=np.int64)
        kernels = np.array([statement.kernel for statement in flat])
        inner_pose = np.arange(poses.sum()) - np.repeat(begins[:-1, 0], poses)
        inner_point = np.arange(points.sum()) - np.repeat(begins[:-1, 1], points)
        W = _diagonal([statement.W for statement in flat], begins[:-1, 3], begins[:-1, 2], begins[-1, 3:1:-1])
        return cls(
            _joined([statement.poses for statement in flat], int),
            np.repeat(frames, poses),
            np.repeat(begins[:-1, 2], poses) + 3 * inner_pose,
            np.repeat(kernels, poses),
            np.repeat(begins[:-1, 3], poses),
            _joined([statement.points for statement in flat], int),
            np.repeat(frames, points),
            np.repeat(begins[:-1, 2] + 3 * poses, points) + 2 * inner_point,
            W,
            csr_array(W.T @ W),
            _joined([statement.z for statement in flat], float),
            _joined([statement.b for statement in flat], float),
            begins[np.append(0, np.cumsum([len(one) for one in maps]))],
            hold,
        )

    def __len__(self) -> int:
        return len(self.begin) - 1

    def part(self, first: int, last: int) -> LocalMaps:
        """Maps first … last − 1."""
        low, high = self.begin[first], self.begin[last]
        poses, points, rows, residuals = (slice(a, b) for a, b in zip(low, high, strict=True))
        return LocalMaps(
            self.pose[poses],
            self.pose_frame[poses],
            self.pose_row[poses] - low[2],
            self.kernel[poses],
            self.kernel_row[poses] - low[3],
            self.point[points],
            self.point_frame[points],
            self.point_row[points] - low[2],
            csr_array(self.W[residuals, rows]),
            csr_array(self.gram[rows, rows]),
            self.z[rows],
            self.b[residuals],
            self.begin[first : last + 1] - low,
            self.hold,
        )

    def first(self, count: int) -> LocalMaps:
        """The first maps, so many."""
        return self.part(0, count)

    def residual(self, state: State) -> Float[np.ndarray, "r"]:
        """e, robust weights not applied."""
        rows = np.empty(len(self.z))
        frames = np.vstack([state.poses, se2.IDENTITY])
        poses = se2.between(frames[self.pose_frame], state.poses[self.pose])
        points = se2.transform(se2.inverse(frames[self.point_frame]), state.control_points[self.point])
        rows[self.pose_row[:, None] + np.arange(3)] = poses
        rows[self.point_row[:, None] + np.arange(2)] = points
        rows -= self.z
        rows[self.pose_row + 2] = se2.wrap(rows[self.pose_row + 2])
        return self.W @ rows - self.b

    def squares(self, state: State) -> tuple[float, float]:
        """Σ ρ(‖e‖²) and the weighted Σ w ‖e‖²."""
        e = self.residual(state)
        robust = np.isfinite(self.kernel)
        s, c2 = self._robust_squares(e), self.kernel[robust] ** 2
        plain = float(e @ e - s.sum())
        return plain + float((c2 * np.log1p(s / c2)).sum()), plain + float((s / (1.0 + s / c2)).sum())

    def cost(self, state: State) -> float:
        """½ Σ ρ(‖e‖²)."""
        return 0.5 * self.squares(state)[0]

    def linearise(self, state: State) -> JointInformation:
        """The information of all maps, summed at this state."""
        e, robust = self.residual(state), np.isfinite(self.kernel)
        weight = 1.0 / (1.0 + self._robust_squares(e) / self.kernel[robust] ** 2)
        rows, residuals = np.ones(len(self.z)), np.ones(len(e))
        rows[self.pose_row[robust, None] + np.arange(3)] = np.sqrt(weight)[:, None]
        residuals[self.kernel_row[robust, None] + np.arange(3)] = weight[:, None]
        jacobian = self.jacobian(state)
        scaled = diags_array(rows) @ jacobian
        gradient = jacobian.T @ (self.W.T @ (residuals * e))
        return JointInformation(csc_array(scaled.T @ (self.gram @ scaled)), gradient, len(state.poses), self.hold)

    def jacobian(self, state: State) -> csr_array:
        """∂h/∂X; unknowns are the poses (x, y, θ), then the points (x, y)."""
        frames, n = np.vstack([state.poses, se2.IDENTITY]), len(state.poses)
        frame = np.concatenate([self.pose_frame, self.point_frame])
        row = np.concatenate([self.pose_row, self.point_row])[:, None] + np.arange(2)
        column = np.concatenate([3 * self.pose, 3 * n + 2 * self.point])[:, None] + np.arange(2)
        world = np.vstack([state.poses[self.pose, :2], state.control_points[self.point]])
        back = se2.rotation(-frames[frame, 2])
        seen = np.einsum("kij,kj->ki", back, world - frames[frame, :2])
        known, turned = frame != WORLD, np.flatnonzero(self.pose_frame != WORLD)
        x = 3 * frame[known]
        blocks = [
            _entries(row, column, back),
            _entries(row[known], x[:, None] + np.arange(2), -back[known]),
            _entries(row[known], x[:, None] + 2, (seen[known, ::-1] * (1.0, -1.0))[:, :, None]),
            (self.pose_row + 2, 3 * self.pose + 2, np.ones(len(self.pose))),
            (self.pose_row[turned] + 2, 3 * self.pose_frame[turned] + 2, -np.ones(len(turned))),
        ]
        rows, columns, values = (np.concatenate(part) for part in zip(*blocks, strict=True))
        unknowns = 3 * n + 2 * len(state.control_points)
        return coo_array((values, (rows, columns)), shape=(len(self.z), unknowns)).tocsr()

    def _robust_squares(self, e: Float[np.ndarray, "r"]) -> Float[np.ndarray, "l"]:
        """‖e‖² of each statement with a kernel."""
        first = self.kernel_row[np.isfinite(self.kernel)]
        return np.square(e[first[:, None] + np.arange(3)]).sum(axis=1)


@dataclass(frozen=True, eq=False, slots=True)
class JointInformation:
    """The sum of local maps at one state: information matrix and gradient over poses (x, y, θ), then points (x, y)."""

    matrix: csc_array
    gradient: Float[np.ndarray, "u"]
    poses: int
    hold: float

    def step(self, damping: float) -> State:
        """−(H + (hold + damping)·I)⁻¹ gradient; what no map speaks of stays. Raises SolverError where singular."""
        known = np.flatnonzero(self.matrix.diagonal() > 0.0)
        held = csc_array(self.matrix[known][:, known] + (self.hold + damping) * eye_array(len(known)))
        options = {"SymmetricMode": True}
        try:
            factor = splu(held, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:
            raise SolverError("the joint map is singular: its local maps leave something open") from error
        solution = np.zeros(len(self.gradient))
        solution[known] = -factor.solve(self.gradient[known])
        return State(solution[: 3 * self.poses].reshape(-1, 3), solution[3 * self.poses :].reshape(-1, 2))


def _joined(parts: Sequence[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([np.empty(0, dtype=kind), *parts])


def _diagonal(
    blocks: Sequence[np.ndarray], row: Int[np.ndarray, "k"], column: Int[np.ndarray, "k"], shape: Int[np.ndarray, "2"]
) -> csr_array:
    """Dense blocks that begin at these rows and columns of a sparse matrix."""
    sizes = np.array([block.size for block in blocks], dtype=np.int64)
    widths = np.repeat(np.array([block.shape[1] for block in blocks], dtype=np.int64), sizes)
    down, along = np.divmod(np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes), widths)
    rows, columns = np.repeat(row, sizes) + down, np.repeat(column, sizes) + along
    values = _joined([block.ravel() for block in blocks], float)
    nonzero = values != 0.0
    return coo_array((values[nonzero], (rows[nonzero], columns[nonzero])), shape=tuple(shape.tolist())).tocsr()


def _entries(
    rows: Int[np.ndarray, "k 2"], columns: Int[np.ndarray, "k c"], blocks: Float[np.ndarray, "k 2 c"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and values of blocks."""
    row = np.broadcast_to(rows[:, :, None], blocks.shape)
    column = np.broadcast_to(columns[:, None, :], blocks.shape)
    return row.ravel(), column.ravel(), blocks.ravel()
