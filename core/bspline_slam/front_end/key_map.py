"""The map of the key scans read so far: what each showed, what was decided about it, and the splines made of that."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association, AssociationConfig
from bspline_slam.calibration.laser_correction import LaserCorrection
from bspline_slam.front_end.mapping import MapBuilder
from bspline_slam.models.protocol import Model
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import SplineMap


@dataclass
class KeyMap:
    """State of the map: the builder of splines, and each key scan as it was read; those that were `lost` show nothing
    that could be associated."""

    association: AssociationConfig
    model: Model
    keys: list[KeyObservations] = field(default_factory=list)
    lost: list[bool] = field(default_factory=list)
    builder: MapBuilder = field(init=False)

    def __post_init__(self) -> None:
        self.builder = MapBuilder(self.association, self.model)

    @property
    def splines(self) -> SplineMap:
        """The map as a value."""
        return self.builder.map

    def observations(self) -> tuple[KeyObservations, ...]:
        """The decisions, with the ids that splines have after joins."""
        renamed = self.builder.renamed
        return tuple(replace(key, associations=tuple(map(renamed, key.associations))) for key in self.keys)

    def add(self, key: KeyObservations, pose: Float[np.ndarray, "3"], *, lost: bool) -> tuple[Association, ...]:
        """One more key scan, associated at its pose; what was decided."""
        self.keys.append(key)
        self.lost.append(lost)
        self._read([len(self.keys) - 1], [pose])
        return self.keys[-1].associations

    def carry(self, before: Float[np.ndarray, "n 3"], after: Float[np.ndarray, "n 3"], since: int) -> None:
        """The map goes along with its key scans; those from number `since` on are read anew, for they drew again what
        was there."""
        n = len(self.keys)
        scans = np.array([key.scan for key in self.keys], dtype=np.int64)
        self.builder.carry(scans, before[:n], after[:n])
        if since < n:
            self.builder.inherited = self._inheritance()
            self.builder.forget(self.keys[since].scan)
            self._read(range(since, n), after[since:n])

    def rebuild(self, poses: Float[np.ndarray, "n 3"]) -> None:
        """The map built anew at these poses; splines keep the ids of those that the same segments began."""
        next_id, inherited = self.builder.next_id, self._inheritance()
        self.builder = MapBuilder(self.association, self.model, inherited, first_id=next_id)
        self._read(range(len(self.keys)), poses)

    def correct(self, correction: LaserCorrection) -> None:
        """Correct the beams of all key scans; the map stays until it is built anew."""
        self.keys = [replace(key, segments=correction.segments(key.segments, key.sensor)) for key in self.keys]

    def _read(self, numbers: Iterable[int], poses: Iterable[Float[np.ndarray, "3"]]) -> None:
        """Associate the segments of key scans anew at these poses."""
        for k, pose in zip(numbers, poses, strict=False):
            key = self.keys[k]
            decided = () if self.lost[k] else self.builder.add(key.scan, pose, key.segments, key.sensor)
            self.keys[k] = replace(key, associations=decided)

    def _inheritance(self) -> Callable[[int, int], int]:
        """Which spline a segment belonged to: that which it begins when it is read anew takes this id again."""
        inherited: dict[tuple[int, int], int] = {}
        for key in self.keys:
            for association in key.associations:
                if association.spline is not None:
                    inherited.setdefault((key.scan, association.segment), self.builder.heir(association.spline))
        return lambda scan, segment: inherited.get((scan, segment), -1)
