"""The graph of key poses and splines, derived from decisions at one linearisation of the foot points."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.adjustment.counted_beams import CountedBeams
from bspline_slam.flat_curves import FlatCurves
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import Beams, Graph, PoseFactor, PosePrior, ShapePrior, square_root
from bspline_slam.models.protocol import Model, SeenBeams
from bspline_slam.sights import Feet, KeyObservations, Sights, find_feet
from bspline_slam.spline_map import MapSpline, SplineMap


def build_graph(
    keys: Sequence[KeyObservations],
    poses: Float[np.ndarray, "n 3"],
    splines: SplineMap,
    factors: Sequence[PoseFactor],
    sights: Sights,
    config: AdjustmentConfig,
    model: Model,
    gate: float | Float[np.ndarray, "m"],
) -> Graph:
    """The least-squares problem at this linearisation of the foot points; splines that no beam reaches are not in
    it."""
    feet = find_feet(sights, splines, poses, gate)
    counted = CountedBeams.of(sights, feet, poses, model.fitting, config.outlier)
    observed = _observations(sights, feet, counted, splines, poses, model)
    counted = counted.only(np.isin(sights.piece[counted.place], observed.pose))
    seen = np.unique(sights.spline[counted.place])
    kept = [splines.splines[k] for k in seen]
    place = np.full(len(splines), -1)
    place[seen] = np.arange(len(seen))
    curves = FlatCurves.of([spline.curve for spline in kept])
    factors_of_splines = [_on_graph(observed, sights, place, curves.point_start)]
    if not model.measures_along:
        factors_of_splines.append(_slides(sights, counted, curves, poses, place, config))
    return Graph(
        key_scans=np.array([key.scan for key in keys], dtype=np.int64),
        poses=poses,
        spline_ids=np.array([spline.id for spline in kept], dtype=np.int64),
        spline_first=curves.point_start,
        control_points=curves.control_points,
        spline_factors=FlatFactors.joined(factors_of_splines),
        pose_factors=_remaining_factors(factors, _told_by_splines(len(poses), sights, counted), config),
        pose_priors=(PosePrior(0, poses[0], np.eye(3) / config.anchor),),
        shape_priors=tuple(_bends(curves, config)),
        beams=_beams(sights, feet, counted, kept, place),
    )


def _observations(
    sights: Sights,
    feet: Feet,
    counted: CountedBeams,
    splines: SplineMap,
    poses: Float[np.ndarray, "n 3"],
    model: Model,
) -> FlatFactors:
    """What the model makes of each association that says something, with the number of its piece for that of the
    pose, on the control points of its own curve."""
    kept, normals = counted.place, counted.normals
    if len(kept) == 0:
        return FlatFactors.of(())
    cuts = np.flatnonzero(np.diff(sights.piece[kept], prepend=-1, append=-1))
    at = kept[cuts[:-1]]
    points, right = sights.points[kept], (normals * sights.points[kept]).sum(1)
    sensors = sights.points[at] - sights.ranges[at, None] * sights.directions[at]
    beams = SeenBeams(cuts, sensors, points, feet.first[kept], feet.basis[kept], normals, right, 1.0 / counted.sigma)
    curves = [splines.splines[k].curve for k in sights.spline[at].tolist()]
    told = model.observe(curves, poses[sights.pose[at]], beams)
    return replace(told, pose=sights.piece[at][told.pose])


def _on_graph(
    observed: FlatFactors, sights: Sights, place: Int[np.ndarray, "s"], spline_first: Int[np.ndarray, "s1"]
) -> FlatFactors:
    """The observations on the poses and the control points of the graph."""
    beam = np.searchsorted(sights.piece, observed.pose)
    first = spline_first[place[sights.spline[beam]]] + observed.first
    return replace(observed, pose=sights.pose[beam], first=first)


def _beams(
    sights: Sights, feet: Feet, counted: CountedBeams, kept: Sequence[MapSpline], place: Int[np.ndarray, "s"]
) -> Beams:
    """The beams that count, each with the noise of its range: that across the curve, seen along the beam."""
    at = counted.place
    directions, ranges = sights.directions[at], sights.ranges[at]
    return Beams(
        sights.pose[at],
        place[sights.spline[at]],
        sights.points[at] - ranges[:, None] * directions,
        directions,
        ranges,
        feet.t[at],
        counted.sigma / np.abs((counted.normals * directions).sum(1)),
        tuple(spline.curve for spline in kept),
    )


def _slides(
    sights: Sights,
    counted: CountedBeams,
    curves: FlatCurves,
    poses: Float[np.ndarray, "n 3"],
    place: Int[np.ndarray, "s"],
    config: AdjustmentConfig,
) -> FlatFactors:
    """Hold each control point along its curve, relative to the pose that saw most of the spline: a gauge, not a
    measurement. The more control points a curve has, the weaker each is held, or a long curve would be tied to one
    pose."""
    seen, owner = sights.pose[counted.place], place[sights.spline[counted.place]]
    cuts = np.searchsorted(owner, np.arange(len(curves.degrees) + 1))
    best = np.array([int(np.bincount(seen[a:b]).argmax()) for a, b in itertools.pairwise(cuts)], dtype=np.int64)
    counts = np.diff(curves.point_start)
    pose = np.repeat(best, counts)
    _, tangents = curves.greville()
    rows = se2.rotate(-poses[pose], tangents) / (config.slide * np.sqrt(np.repeat(counts, counts)))[:, None]
    local = se2.transform(se2.inverse(poses[pose]), curves.control_points)
    right, count = (rows * local).sum(1), len(pose)
    nothing = np.zeros(count, dtype=np.int64)
    one = np.ones((count, 2), dtype=np.int64)
    return FlatFactors.laid_out(pose, np.arange(count), one, rows.ravel(), right, nothing, np.zeros(count))


def _bends(curves: FlatCurves, config: AdjustmentConfig) -> Iterator[ShapePrior]:
    """Second differences over Greville abscissae: nothing bends a straight curve, wherever its knots are."""
    abscissae, _ = curves.greville()
    gaps = np.diff(abscissae)
    inner = np.ones(max(len(gaps) - 1, 0), dtype=bool)
    inner[curves.point_start[1:-1] - 1] = False
    inner[curves.point_start[1:-1] - 2] = False
    first = np.flatnonzero(inner)
    share = gaps[first] / (gaps[first] + gaps[first + 1])
    rows = np.zeros((len(first), 2, 3, 2))
    for axis in range(2):
        rows[:, axis, :, axis] = np.stack([2.0 - 2.0 * share, np.full(len(share), -2.0), 2.0 * share], -1)
    for i, row in zip(first.tolist(), rows.reshape(-1, 2, 6) / config.bend, strict=True):
        yield ShapePrior(i, row, np.zeros(2))


NOTHING_SAID = 1e-6
"""Information (1/m², 1/rad²) along a direction that neither a match nor any spline speaks of."""


def _remaining_factors(
    factors: Sequence[PoseFactor], told: Float[np.ndarray, "n 3 3"], config: AdjustmentConfig
) -> tuple[PoseFactor, ...]:
    """Odometry as it is; scan matching and loop closures by what they know and no spline says.

    Their beams already speak through the splines: of an information Λ the share Λ(Λ + H)⁻¹Λ is left, H being what
    the splines have `told` of the same pose. Along a corridor that is nearly all, across it next to nothing.
    """
    matched = [factor for factor in factors if factor.kind != "odometry"]
    if not matched:
        return tuple(factors)
    roots = np.array([factor.sqrt_information for factor in matched])
    known = roots.swapaxes(1, 2) @ roots
    share, seen = config.explained_weight, told[[factor.j for factor in matched]]
    all_told = known + seen + NOTHING_SAID * np.eye(3)
    left = iter(square_root(share * known + (1.0 - share) * known @ np.linalg.solve(all_told, known)))
    return tuple(f if f.kind == "odometry" else replace(f, sqrt_information=next(left)) for f in factors)


def _told_by_splines(count: int, sights: Sights, counted: CountedBeams) -> Float[np.ndarray, "n 3 3"]:
    """The information of the beams on each of so many poses (in its own frame), the map taken as known."""
    pose, points, normals = sights.pose[counted.place], sights.points[counted.place], counted.normals
    turn = normals[:, 1] * points[:, 0] - normals[:, 0] * points[:, 1]
    rows = np.column_stack([normals, turn]) / counted.sigma[:, None]
    told = np.empty((count, 3, 3))
    for a, b in itertools.combinations_with_replacement(range(3), 2):
        told[:, a, b] = told[:, b, a] = np.bincount(pose, rows[:, a] * rows[:, b], count)
    return told
