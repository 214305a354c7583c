"""A result with edits on its way from the editor's process to the estimator's, which both know the result without."""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np

from bspline_slam.slam import Snapshot


def packed(base: Snapshot, amended: Snapshot) -> bytes:
    """A result with edits as bytes; what is as in the result without is only named."""
    file = io.BytesIO()
    _Packer(file, base).dump(amended)
    return file.getvalue()


def unpacked(base: Snapshot, amended: bytes) -> Snapshot:
    """The result with edits, from the same result without."""
    return _Unpacker(io.BytesIO(amended), base).load()


class _Packer(pickle.Pickler):
    def __init__(self, file: io.BytesIO, base: Snapshot) -> None:
        super().__init__(file, protocol=5)
        self._numbers = {id(part): number for number, part in enumerate(_parts(base))}

    def persistent_id(self, obj: Any) -> int | None:
        return self._numbers.get(id(obj))


class _Unpacker(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, base: Snapshot) -> None:
        super().__init__(file)
        self._parts = tuple(_parts(base))

    def persistent_load(self, pid: int) -> Any:
        return self._parts[pid]


def _parts(base: Snapshot) -> Iterator[Any]:
    """What results with edits may share with that without, always in the same order."""
    graph = base.estimate.graph if base.estimate is not None else None
    if graph is not None:
        yield from (*graph.pose_factors, *graph.shape_priors, *graph.pose_priors)
    yield from (*base.pose_factors, *base.loop_closures, *base.map, *base.observations, *base.steps)
    for key in base.observations:
        yield from (*key.segments, *key.associations)
    for step in base.steps:
        parts = (step.segments, step.associations, step.loop_closures, step.predicted, step.pose)
        yield from (part for part in parts if isinstance(part, np.ndarray) or part)
