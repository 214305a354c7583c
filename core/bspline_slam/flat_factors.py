"""Many spline factors as flat arrays, in the order that compiled kernels read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam.graph import SplineFactor


@dataclass(frozen=True, eq=False, slots=True)
class FlatFactors(Sequence[SplineFactor]):
    """Spline factors one after another; read one by one, each is a SplineFactor on views of these arrays.

    `size` holds the rows r and the control points m of each, `start` where its A (r, 2m) and its b (r,) begin.
    """

    pose: Int[np.ndarray, "f"]
    first: Int[np.ndarray, "f"]
    size: Int[np.ndarray, "f 2"]
    start: Int[np.ndarray, "f 2"]
    A: Float[np.ndarray, "a"]
    b: Float[np.ndarray, "b"]
    readings: Int[np.ndarray, "f"]
    constant: Float[np.ndarray, "f"]

    @classmethod
    def laid_out(
        cls,
        pose: Int[np.ndarray, "f"],
        first: Int[np.ndarray, "f"],
        size: Int[np.ndarray, "f 2"],
        A: Float[np.ndarray, "a"],
        b: Float[np.ndarray, "b"],
        readings: Int[np.ndarray, "f"],
        constant: Float[np.ndarray, "f"],
    ) -> FlatFactors:
        """Factors whose A and b follow each other without gaps."""
        lengths = np.column_stack([2 * size[:, 0] * size[:, 1], size[:, 0]])
        return cls(pose, first, size, np.cumsum(lengths, axis=0) - lengths, A, b, readings, constant)

    @classmethod
    def of(cls, factors: Sequence[SplineFactor]) -> FlatFactors:
        """The same factors, flat."""
        if isinstance(factors, FlatFactors):
            return factors
        numbers = np.array(
            [(f.pose, f.first, len(f.b), f.A.shape[1] // 2, f.readings) for f in factors], dtype=np.int64
        ).reshape(-1, 5)
        return cls.laid_out(
            numbers[:, 0],
            numbers[:, 1],
            numbers[:, 2:4],
            np.concatenate([np.empty(0), *(factor.A.ravel() for factor in factors)]),
            np.concatenate([np.empty(0), *(factor.b for factor in factors)]),
            numbers[:, 4],
            np.array([factor.constant for factor in factors], dtype=float),
        )

    @classmethod
    def joined(cls, parts: Sequence[FlatFactors]) -> FlatFactors:
        """Those of all parts, one part after another."""
        ends = np.cumsum([(0, 0), *((len(part.A), len(part.b)) for part in parts)], axis=0)
        return cls(
            np.concatenate([part.pose for part in parts]),
            np.concatenate([part.first for part in parts]),
            np.concatenate([part.size for part in parts]),
            np.concatenate([part.start + end for part, end in zip(parts, ends, strict=False)]),
            np.concatenate([part.A for part in parts]),
            np.concatenate([part.b for part in parts]),
            np.concatenate([part.readings for part in parts]),
            np.concatenate([part.constant for part in parts]),
        )

    def chosen(self, which: Bool[np.ndarray, "f"]) -> FlatFactors:
        """Some of the factors, in their order; A and b are shared."""
        return replace(
            self,
            pose=self.pose[which],
            first=self.first[which],
            size=self.size[which],
            start=self.start[which],
            readings=self.readings[which],
            constant=self.constant[which],
        )

    def compact(self) -> FlatFactors:
        """The same without what no factor of A and b reads; itself, where that is less than half of what one reads."""
        lengths = np.column_stack([2 * self.size[:, 0] * self.size[:, 1], self.size[:, 0]])
        if 1.5 * lengths[:, 0].sum() >= len(self.A):
            return self
        begins = np.cumsum(lengths, axis=0) - lengths
        A, b = (
            values[np.repeat(self.start[:, k] - begins[:, k], lengths[:, k]) + np.arange(lengths[:, k].sum())]
            for k, values in enumerate((self.A, self.b))
        )
        return replace(self, start=begins, A=A, b=b)

    @property
    def measured(self) -> Int[np.ndarray, "f"]:
        """How many numbers each factor measures: a distance for each beam; where it sums nothing up beyond its rows,
        those; none where it is only a gauge."""
        return np.where(self.constant > 0, self.readings, np.where(self.readings > 0, self.size[:, 0], 0))

    def __len__(self) -> int:
        return len(self.pose)

    @overload
    def __getitem__(self, k: int) -> SplineFactor: ...
    @overload
    def __getitem__(self, k: slice) -> tuple[SplineFactor, ...]: ...
    def __getitem__(self, k: int | slice) -> SplineFactor | tuple[SplineFactor, ...]:
        if isinstance(k, slice):
            return tuple(self[number] for number in range(*k.indices(len(self))))
        (rows, points), (a, b) = self.size[k].tolist(), self.start[k].tolist()
        A = self.A[a : a + 2 * rows * points].reshape(rows, 2 * points)
        numbers = int(self.pose[k]), int(self.first[k]), A, self.b[b : b + rows]
        return SplineFactor(*numbers, int(self.readings[k]), float(self.constant[k]))

    def __iter__(self) -> Iterator[SplineFactor]:
        columns = (self.pose, self.first, self.size, self.start, self.readings, self.constant)
        for pose, first, (rows, points), (a, b), readings, constant in zip(*(c.tolist() for c in columns), strict=True):
            A = self.A[a : a + 2 * rows * points].reshape(rows, 2 * points)
            yield SplineFactor(pose, first, A, self.b[b : b + rows], readings, constant)
