"""Joining local point-feature maps made elsewhere, by I-SLSJF (Huang et al. 2008).

A file of local maps holds for k = 0, 1, … the arrays `x{k}` (3 + 2m,): the end pose x, y, θ and then x, y of each
feature, all in the frame of the map's start pose; `P{k}` (3 + 2m, 3 + 2m), its covariance; and `id{k}` (m,), the
features' numbers. Map k + 1 starts where map k ends. Metres and radians; equal numbers are the same feature.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import solve_triangular
from scipy.sparse import coo_array, csc_array

from bspline_slam import se2
from bspline_slam.backends.gauss_newton import State, Stopping
from bspline_slam.backends.islsjf import join
from bspline_slam.backends.local_maps import WORLD, LocalMaps, Statement
from bspline_slam.backends.protocol import Cancelling, IterationRecord, Progress, never, silent
from bspline_slam.backends.threads import single_thread
from bspline_slam.errors import LocalMapError

ARRAY_NAME = re.compile(r"(?:x|P|id)(0|[1-9][0-9]*)")
ASYMMETRY = 1e-6
"""Largest difference of a covariance from its transpose, as a fraction of its largest entry, that rounding explains."""


@dataclass(frozen=True, eq=False, slots=True)
class PointMap:
    """One local map: end pose and features in the frame of its start pose, with their covariance."""

    end: Float[np.ndarray, "3"]
    features: Float[np.ndarray, "m 2"]
    covariance: Float[np.ndarray, "d d"]
    ids: Int[np.ndarray, "m"]


@dataclass(frozen=True, eq=False, slots=True)
class JointMap:
    """All local maps in the frame of the first start pose.

    `poses[0]` is that start pose, the origin, and `poses[k + 1]` the end of map k; `features[j]` is the feature
    numbered `feature_ids[j]`. `information` is the inverse of the covariance of (poses[1:], features), unknowns in
    that order: x, y, θ of each pose, then x, y of each feature. χ² is that of all local maps.
    """

    poses: Float[np.ndarray, "k1 3"]
    features: Float[np.ndarray, "f 2"]
    feature_ids: Int[np.ndarray, "f"]
    information: csc_array
    iterations: tuple[IterationRecord, ...]
    converged: bool
    chi2: float
    dof: int

    @property
    def unknowns(self) -> int:
        return 3 * (len(self.poses) - 1) + 2 * len(self.features)

    def to_npz(self, path: Path) -> None:
        """Write `poses`, `features`, `feature_ids`, and `information` as rows (row, column, value), both halves."""
        parts = self.information.tocoo()
        np.savez(
            path,
            poses=self.poses,
            features=self.features,
            feature_ids=self.feature_ids,
            information=np.column_stack([parts.row, parts.col, parts.data]),
        )


def read_information(path: Path) -> csc_array:
    """The information matrix of a written joint map."""
    with np.load(path) as arrays:
        row, column, value = arrays["information"].T
        unknowns = 3 * (len(arrays["poses"]) - 1) + 2 * len(arrays["features"])
    places = (row.astype(np.int64), column.astype(np.int64))
    return csc_array(coo_array((value, places), shape=(unknowns, unknowns)))


def read_point_maps(path: Path) -> tuple[PointMap, ...]:
    """The local maps of an .npz file. Raises LocalMapError naming the array that is missing or wrong."""
    try:
        with np.load(path) as arrays:
            found = {name: arrays[name] for name in arrays.files}
    except (zipfile.BadZipFile, ValueError, EOFError, AttributeError, TypeError) as error:
        raise LocalMapError(path, "is no .npz file of plain arrays") from error
    numbers = [int(match[1]) for name in found if (match := ARRAY_NAME.fullmatch(name))]
    if not numbers:
        raise LocalMapError(path, "holds no local map: the first is the arrays x0, P0 and id0")
    return tuple(_point_map(path, found, k) for k in range(max(numbers) + 1))


def _point_map(path: Path, arrays: dict[str, np.ndarray], k: int) -> PointMap:
    """Map k, checked."""
    for name in (f"x{k}", f"P{k}", f"id{k}"):
        if name not in arrays:
            raise LocalMapError(path, f"array {name} is missing")
    x, P, ids = arrays[f"x{k}"], arrays[f"P{k}"], arrays[f"id{k}"]
    size = 3 + 2 * ids.size
    if ids.ndim != 1 or not _are_integers(ids):
        raise LocalMapError(path, f"id{k} must be a list of integers, not {ids.dtype} of shape {ids.shape}")
    if x.shape != (size,) or P.shape != (size, size):
        rule = f"with {ids.size} features x{k} must be ({size},) and P{k} ({size}, {size}), not {x.shape} and {P.shape}"
        raise LocalMapError(path, rule)
    if not (_is_finite(x) and _is_finite(P)):
        raise LocalMapError(path, f"x{k} or P{k} holds values that are not finite numbers")
    unique, counts = np.unique(ids, return_counts=True)
    if np.any(counts > 1):
        raise LocalMapError(path, f"id{k} names feature {unique[counts > 1][0]} twice")
    if np.abs(P - P.T).max() > ASYMMETRY * np.abs(P).max():
        raise LocalMapError(path, f"P{k} is not symmetric")
    covariance = (P + P.T) / 2.0
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError as error:
        raise LocalMapError(path, f"P{k} is not positive definite") from error
    return PointMap(x[:3].astype(float), x[3:].reshape(-1, 2).astype(float), covariance, ids.astype(np.int64))


def _are_integers(ids: np.ndarray) -> bool:
    """Whether these are whole numbers of 64 bits; that they are stored as floats does no harm."""
    if ids.dtype.kind not in "iuf" or not _is_finite(ids):
        return False
    low, high = ids.min(initial=0), ids.max(initial=0)
    return bool(low >= -(2**63) and high < 2**63 and np.all(ids == np.floor(ids)))


def _is_finite(values: np.ndarray) -> bool:
    return np.issubdtype(values.dtype, np.number) and np.isrealobj(values) and bool(np.all(np.isfinite(values)))


def join_point_maps(
    maps: Sequence[PointMap],
    stopping: Stopping | None = None,
    *,
    progress: Progress = silent,
    cancelled: Cancelling = never,
) -> JointMap:
    """The joint map: from composed odometry and the first sight of each feature to the least-squares optimum.

    Raises SolverError where covariances are too far apart for the arithmetic, and Cancelled.
    """
    feature_ids = np.unique(np.concatenate([one.ids for one in maps]))
    with single_thread():
        local = LocalMaps.from_statements([[_statement(k, one, feature_ids)] for k, one in enumerate(maps)])
    start = first_guess(maps, feature_ids)
    descent = join(local, local.first, start, stopping or Stopping(), progress, cancelled)
    state = descent.state
    return JointMap(
        np.vstack([se2.IDENTITY, state.poses]),
        state.control_points,
        feature_ids,
        local.linearise(state).matrix,
        descent.records,
        descent.converged,
        local.squares(state)[1],
        len(local.b) - 3 * len(maps) - 2 * len(feature_ids),
    )


def _statement(k: int, one: PointMap, feature_ids: Int[np.ndarray, "f"]) -> Statement:
    """Map k as a statement on its end pose, number k of the state, and its features; map 0 starts at the origin."""
    size = len(one.covariance)
    root = solve_triangular(np.linalg.cholesky(one.covariance), np.eye(size), lower=True)
    z = np.append(one.end, one.features.ravel())
    start = WORLD if k == 0 else k - 1
    return Statement(start, np.array([k]), np.searchsorted(feature_ids, one.ids), root, z, np.zeros(size))


def first_guess(maps: Sequence[PointMap], feature_ids: Int[np.ndarray, "f"]) -> State:
    """End poses composed one after another, and each feature where the first map that has it puts it."""
    pose, poses = se2.IDENTITY, []
    features, seen = np.zeros((len(feature_ids), 2)), np.zeros(len(feature_ids), dtype=bool)
    for one in maps:
        places = np.searchsorted(feature_ids, one.ids)
        new = ~seen[places]
        features[places[new]] = se2.transform(pose, one.features[new])
        seen[places] = True
        pose = se2.compose(pose, one.end)
        poses.append(pose)
    return State(np.array(poses), features)
