"""Curves cut into short stretches, each with how far beams end from it: where a map is crisp and where it is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.lab.residuals import BeamResiduals
from bspline_slam.spline_map import SplineMap

LENGTH = 0.25
"""Of a stretch (m), about."""
LEAST_BEAMS = 5
"""Fewer beams than these on a stretch say nothing of it."""


@dataclass(frozen=True, eq=False, slots=True)
class Stretches:
    """Stretches of the splines of a map, along each in order: id of the spline, parameters of both ends, and a value
    (m): root mean square distance of the beams that saw it, unless said otherwise; NaN where that is not known."""

    spline: Int[np.ndarray, "s"]
    start: Float[np.ndarray, "s"]
    end: Float[np.ndarray, "s"]
    value: Float[np.ndarray, "s"]

    @classmethod
    def of(cls, splines: SplineMap, residuals: BeamResiduals) -> Stretches:
        """The supported stretch of each spline, cut evenly along its length; NaN where too few beams saw it."""
        cuts = np.searchsorted(residuals.spline, np.arange(len(splines) + 1))
        none = np.zeros(0)
        spline, start, end, rms = [np.zeros(0, dtype=np.int64)], [none], [none], [none]
        for one, a, b in zip(splines, cuts[:-1], cuts[1:], strict=True):
            edges, _ = one.sample(LENGTH)
            start.append(edges[:-1])
            end.append(edges[1:])
            rms.append(binned_rms(residuals.t[a:b], residuals.across[a:b], edges))
            spline.append(np.full(len(edges) - 1, one.id))
        return cls(*(np.concatenate(column) for column in (spline, start, end, rms)))


def binned_rms(
    t: Float[np.ndarray, "m"], values: Float[np.ndarray, "m"], edges: Float[np.ndarray, "e"]
) -> Float[np.ndarray, "b"]:
    """Root mean square of the values whose t lies between neighbouring edges; NaN where there are too few."""
    bins = len(edges) - 1
    place = np.clip(np.searchsorted(edges, t, side="right") - 1, 0, bins - 1)
    counts = np.bincount(place, minlength=bins)
    squares = np.bincount(place, weights=values**2, minlength=bins)
    return np.where(counts >= LEAST_BEAMS, np.sqrt(squares / np.maximum(counts, 1)), np.nan)
