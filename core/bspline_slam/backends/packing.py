"""A graph as flat arrays, in the order that the compiled kernels read; made once per solve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import Graph, ShapePrior
from bspline_slam.kernels import linearise
from bspline_slam.kernels import squares as kernels

WORLD = -1
"""The observer of a term that is seen from the world frame: shape priors and pose priors."""


@dataclass(frozen=True, eq=False, slots=True)
class CurveTerms:
    """Spline factors and shape priors: terms e = A·vec(Rᵀ(c − x)) − b, flat one after another.

    `size` holds rows r and control points m, `start` where A, b and AᵀA of a term begin.
    """

    observer: Int[np.ndarray, "f"]
    first: Int[np.ndarray, "f"]
    size: Int[np.ndarray, "f 2"]
    start: Int[np.ndarray, "f 3"]
    A: Float[np.ndarray, "a"]
    b: Float[np.ndarray, "b"]
    gram: Float[np.ndarray, "g"]

    def only(self, chosen: Bool[np.ndarray, "f"]) -> CurveTerms:
        """The chosen terms."""
        return replace(
            self,
            observer=self.observer[chosen],
            first=self.first[chosen],
            size=self.size[chosen],
            start=self.start[chosen],
        )

    def cost(self, poses: Float[np.ndarray, "n 3"], control_points: Float[np.ndarray, "N 2"]) -> float:
        """Σ ‖e‖²."""
        if len(self.first) == 0:
            return 0.0
        return linearise.curve_cost(
            poses, control_points, self.observer, self.first, self.size, self.start, self.A, self.b
        )

    def squares(
        self, poses: Float[np.ndarray, "n 3"], control_points: Float[np.ndarray, "N 2"]
    ) -> Float[np.ndarray, "f"]:
        """‖e‖² of each term."""
        found = np.zeros(len(self.first))
        kernels.curve_squares(
            poses, control_points, self.observer, self.first, self.size, self.start, self.A, self.b, found
        )
        return found


@dataclass(frozen=True, eq=False, slots=True)
class EdgeTerms:
    """Pose factors and pose priors: relative poses tail → head with the width of their Cauchy kernel (inf: none)."""

    tail: Int[np.ndarray, "e"]
    head: Int[np.ndarray, "e"]
    measured: Float[np.ndarray, "e 3"]
    sqrt_information: Float[np.ndarray, "e 3 3"]
    kernel: Float[np.ndarray, "e"]

    def first(self, count: int) -> EdgeTerms:
        """The first terms: pose factors come before priors."""
        return self.only(slice(count))

    def only(self, chosen: slice | Bool[np.ndarray, "e"]) -> EdgeTerms:
        """The chosen terms."""
        return EdgeTerms(
            self.tail[chosen],
            self.head[chosen],
            self.measured[chosen],
            self.sqrt_information[chosen],
            self.kernel[chosen],
        )

    def cost(self, poses: Float[np.ndarray, "n 3"]) -> tuple[float, float]:
        """Σ ρ(‖e‖²) and the weighted Σ w ‖e‖²."""
        return linearise.edge_cost(poses, self.tail, self.head, self.measured, self.sqrt_information, self.kernel)


def pack_curves(graph: Graph) -> CurveTerms:
    """All spline factors, then all shape priors."""
    terms = FlatFactors.joined([FlatFactors.of(graph.spline_factors), _shapes(graph.shape_priors)])
    squares = np.square(2 * terms.size[:, 1])
    start = np.column_stack([terms.start, np.cumsum(squares) - squares])
    packed = CurveTerms(terms.pose, terms.first, terms.size, start, terms.A, terms.b, np.empty(squares.sum()))
    linearise.square_terms(packed.size, packed.start, packed.A, packed.gram)
    return packed


def _shapes(priors: Sequence[ShapePrior]) -> FlatFactors:
    """Shape priors as factors that are seen from the world frame."""
    count = len(priors)
    rows = np.array([prior.A.shape for prior in priors], dtype=np.int64).reshape(-1, 2) // (1, 2)
    return FlatFactors.laid_out(
        np.full(count, WORLD),
        np.array([prior.first for prior in priors], dtype=np.int64),
        rows,
        np.concatenate([np.zeros(0), *(prior.A.ravel() for prior in priors)]),
        np.concatenate([np.zeros(0), *(prior.b for prior in priors)]),
        np.zeros(count, dtype=np.int64),
        np.zeros(count),
    )


def pack_edges(graph: Graph) -> EdgeTerms:
    """All pose factors, then all pose priors as relative poses from the world frame."""
    factors, priors = graph.pose_factors, graph.pose_priors
    means = np.array([prior.mean for prior in priors]).reshape(-1, 3)
    turned = np.array([prior.sqrt_information for prior in priors]).reshape(-1, 3, 3)
    turned[:, :, :2] = turned[:, :, :2] @ se2.rotation(means[:, 2])
    kernels = [np.inf if factor.kernel is None else factor.kernel for factor in factors]
    return EdgeTerms(
        np.array([factor.i for factor in factors] + [WORLD] * len(priors), dtype=np.int64),
        np.array([factor.j for factor in factors] + [prior.pose for prior in priors], dtype=np.int64),
        np.concatenate([np.array([factor.measured for factor in factors]).reshape(-1, 3), means]),
        np.concatenate([np.array([factor.sqrt_information for factor in factors]).reshape(-1, 3, 3), turned]),
        np.array(kernels + [np.inf] * len(priors)),
    )
