"""Spline adjustment: the graph derived from decisions, solved, with new foot points each round, until nothing
moves."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.backends import IN_ORDER, ONE_PASS, Stopping, back_end, solve_control_points
from bspline_slam.backends.islsjf import JOINING_RECORDS
from bspline_slam.backends.one_pass import records_of
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, never
from bspline_slam.bspline import BSpline
from bspline_slam.errors import Cancelled
from bspline_slam.fitting import FittingConfig
from bspline_slam.graph import Beams, Graph, PoseFactor, PosePrior, ShapePrior, SplineFactor
from bspline_slam.knots import greville
from bspline_slam.laser_noise import calibrated
from bspline_slam.models.protocol import Model, SeenBeams
from bspline_slam.observation import SplineObservation, across_sigma
from bspline_slam.sights import Feet, KeyObservations, Sights, collect_sights, find_feet
from bspline_slam.spline_map import MapSpline, SplineMap
from bspline_slam.trimming import TrimmingConfig, thinned, trimmed


@dataclass(frozen=True, slots=True)
class AdjustmentConfig:
    """Rounds of foot points, the gate of each (m), and what keeps free directions in place.

    Beams farther off than `outlier` standard deviations count as if they were as noisy as that. `bend` is the standard
    deviation (m) of second differences of control points, `slide` that of a whole curve along itself as its best
    observer sees it: nothing measures that direction, so it only fixes the parametrisation. `anchor` holds the first
    pose (m, rad). `explained_weight` is the least share of a scan-matching factor that is kept: its beams already speak
    through the splines. Curves are trimmed every round. Half way the noise of the laser is estimated from what is left
    over (`estimate_noise`; else it is as configured), and knots that earn nothing are taken out.
    """

    gates: tuple[float, ...] = (0.15, 0.1, 0.08, 0.08)
    outlier: float = 2.0
    bend: float = 0.5
    slide: float = 0.05
    anchor: float = 1e-5
    explained_weight: float = 0.02
    trimming: TrimmingConfig = TrimmingConfig()
    estimate_noise: bool = True


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
    observed = list(_observations(sights, feet, splines, poses, config, model))
    told = np.isin(sights.piece, [piece for piece, _ in observed])
    feet = replace(feet, counts=feet.counts & told)
    seen = np.unique(sights.spline[feet.counts])
    kept = [splines.splines[k] for k in seen]
    place = np.full(len(splines), -1)
    place[seen] = np.arange(len(seen))
    counts = np.array([len(spline.curve.control_points) for spline in kept], dtype=np.int64)
    spline_first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    control_points = np.concatenate([s.curve.control_points for s in kept]) if kept else np.zeros((0, 2))
    held = () if model.measures_along else _slides(sights, feet, kept, poses, place, spline_first, config)
    return Graph(
        key_scans=np.array([key.scan for key in keys], dtype=np.int64),
        poses=poses,
        spline_ids=np.array([spline.id for spline in kept], dtype=np.int64),
        spline_first=spline_first,
        control_points=control_points,
        spline_factors=(*_spline_factors(observed, sights, place, spline_first), *held),
        pose_factors=_remaining_factors(factors, keys, sights, feet, config),
        pose_priors=(PosePrior(0, poses[0], np.eye(3) / config.anchor),),
        shape_priors=tuple(_bends(kept, spline_first, config)),
        beams=_beams(sights, feet, kept, poses, place, config, model.fitting),
    )


def _observations(
    sights: Sights,
    feet: Feet,
    splines: SplineMap,
    poses: Float[np.ndarray, "n 3"],
    config: AdjustmentConfig,
    model: Model,
) -> Iterator[tuple[int, SplineObservation]]:
    """What the model makes of each association that says something, with the number of its piece."""
    kept = np.flatnonzero(feet.counts)
    normals = se2.rotate(-poses[sights.pose[kept]], feet.normals[kept])
    sigma = across_sigma(normals, sights.directions[kept], sights.ranges[kept], model.fitting)
    weight = 1.0 / np.maximum(sigma, np.abs(feet.across[kept]) / config.outlier)
    right = (normals * sights.points[kept]).sum(1)
    cuts = np.flatnonzero(np.diff(sights.piece[kept], prepend=-1, append=-1))
    for a, b in itertools.pairwise(cuts):
        at, mine = kept[a], kept[a:b]
        sensor = sights.points[at] - sights.ranges[at] * sights.directions[at]
        beams = SeenBeams(
            sights.points[mine], feet.first[mine], feet.basis[mine], normals[a:b], right[a:b], weight[a:b], sensor
        )
        one = model.observe(splines.splines[sights.spline[at]].curve, poses[sights.pose[at]], beams)
        if one is not None:
            yield int(sights.piece[at]), one


def _spline_factors(
    observed: Sequence[tuple[int, SplineObservation]],
    sights: Sights,
    place: Int[np.ndarray, "s"],
    spline_first: Int[np.ndarray, "s1"],
) -> Iterator[SplineFactor]:
    """The observations on the control points of the graph."""
    beam = np.searchsorted(sights.piece, [piece for piece, _ in observed])
    offsets, poses = spline_first[place[sights.spline[beam]]], sights.pose[beam]
    for (_, one), offset, pose in zip(observed, offsets.tolist(), poses.tolist(), strict=True):
        yield SplineFactor(pose, offset + one.first, one.A, one.b, one.readings, one.constant)


def _beams(
    sights: Sights,
    feet: Feet,
    kept: Sequence[MapSpline],
    poses: Float[np.ndarray, "n 3"],
    place: Int[np.ndarray, "s"],
    config: AdjustmentConfig,
    fitting: FittingConfig,
) -> Beams:
    """The beams that count, each with the noise of its range: that across the curve, seen along the beam."""
    counts = feet.counts
    pose, directions, ranges = sights.pose[counts], sights.directions[counts], sights.ranges[counts]
    normals = se2.rotate(-poses[pose], feet.normals[counts])
    across = across_sigma(normals, directions, ranges, fitting)
    across = np.maximum(across, np.abs(feet.across[counts]) / config.outlier)
    return Beams(
        pose,
        place[sights.spline[counts]],
        sights.points[counts] - ranges[:, None] * directions,
        directions,
        ranges,
        feet.t[counts],
        across / np.abs((normals * directions).sum(1)),
        tuple(spline.curve for spline in kept),
    )


def _slides(
    sights: Sights,
    feet: Feet,
    kept: Sequence[MapSpline],
    poses: Float[np.ndarray, "n 3"],
    place: Int[np.ndarray, "s"],
    spline_first: Int[np.ndarray, "s1"],
    config: AdjustmentConfig,
) -> Iterator[SplineFactor]:
    """Hold each control point along its curve, relative to the pose that saw most of the spline: a gauge, not a
    measurement. The more control points a curve has, the weaker each is held, or a long curve would be tied to one
    pose."""
    seen, owner = sights.pose[feet.counts], place[sights.spline[feet.counts]]
    cuts = np.searchsorted(owner, np.arange(len(kept) + 1))
    for k, spline in enumerate(kept):
        pose = int(np.bincount(seen[cuts[k] : cuts[k + 1]]).argmax())
        tangents = se2.rotate(-poses[pose], greville_tangents(spline.curve))
        local = se2.transform(se2.inverse(poses[pose]), spline.curve.control_points)
        for i, (tangent, q) in enumerate(zip(tangents, local, strict=True)):
            row = tangent[None] / (config.slide * np.sqrt(len(local)))
            yield SplineFactor(pose, int(spline_first[k]) + i, row, row @ q)


def greville_tangents(curve: BSpline) -> Float[np.ndarray, "n 2"]:
    """Unit tangents of the curve at the Greville abscissae of its control points."""
    tangent = curve(np.clip(greville(curve), *curve.domain), 1)
    return tangent / np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)


def _bends(
    kept: Sequence[MapSpline], spline_first: Int[np.ndarray, "s1"], config: AdjustmentConfig
) -> Iterator[ShapePrior]:
    """Second differences over Greville abscissae: nothing bends a straight curve, wherever its knots are."""
    for spline, offset in zip(kept, spline_first.tolist(), strict=False):
        gaps = np.diff(greville(spline.curve))
        share = gaps[:-1] / (gaps[:-1] + gaps[1:])
        weights = np.stack([2.0 - 2.0 * share, np.full(len(share), -2.0), 2.0 * share], -1) / config.bend
        for i, row in enumerate(weights):
            yield ShapePrior(offset + i, np.kron(row[None], np.eye(2)), np.zeros(2))


def _remaining_factors(
    factors: Sequence[PoseFactor],
    keys: Sequence[KeyObservations],
    sights: Sights,
    feet: Feet,
    config: AdjustmentConfig,
) -> tuple[PoseFactor, ...]:
    """Odometry as it is; scan matching and loop closures by the share of beams that no spline speaks for."""
    spoken = np.bincount(sights.pose[feet.counts], minlength=len(keys))
    beams = np.array([max(key.beams, 1) for key in keys])
    weight = np.clip(1.0 - spoken / beams, config.explained_weight, 1.0)
    return tuple(
        factor
        if factor.kind == "odometry"
        else replace(factor, sqrt_information=factor.sqrt_information * np.sqrt(weight[factor.j]))
        for factor in factors
    )


def with_estimate(splines: SplineMap, estimate: Estimate) -> SplineMap:
    """The map with the control points of an estimate; splines that were not in the graph are gone."""
    graph = estimate.graph
    by_id = {spline.id: spline for spline in splines}
    out = []
    for k, spline_id in enumerate(graph.spline_ids):
        spline = by_id[int(spline_id)]
        a, b = graph.spline_first[k], graph.spline_first[k + 1]
        out.append(replace(spline, curve=spline.curve.with_control_points(estimate.control_points[a:b])))
    return SplineMap(tuple(out))


ROUGHLY = Stopping(decrease=1e-4, move=1e-3, iterations=4)
"""Rounds before the last find new foot points anyway."""

FIRMER = 0.4
"""Share of `slide` while foot points are found anew: curves held more weakly creep along themselves, round by round,
and the descent takes ten times the steps."""

RoundProgress = Callable[[float, IterationRecord | None], None]


def adjust_splines(
    keys: Sequence[KeyObservations],
    poses: Float[np.ndarray, "n 3"],
    splines: SplineMap,
    factors: Sequence[PoseFactor],
    config: AdjustmentConfig,
    model: Model,
    name: str,
    progress: RoundProgress,
    cancelled: Cancelling = never,
) -> tuple[SplineMap, Estimate]:
    """Solve, find new foot points, solve again: the adjusted map and the estimate of the last round.

    The estimate's iterations run over all rounds. A back end that takes the key scans in their order does so in
    the last; `direct` finds it the foot points in those before. Raises Cancelled; ConfigError for an unknown back end.
    """
    records: list[IterationRecord] = []
    estimate: Estimate | None = None
    firm = replace(config, slide=FIRMER * config.slide)
    for number, gate in enumerate(config.gates):
        if cancelled():
            raise Cancelled("the adjustment was cancelled")
        sights = collect_sights(keys, splines)
        splines = trimmed(splines, sights, find_feet(sights, splines, poses, gate), config.trimming, model)
        last, half = number + 1 == len(config.gates), number == len(config.gates) // 2
        if (half or last) and not model.measures_along:
            feet = find_feet(sights, splines, poses, gate)
            model = calibrated(model, splines, sights, feet, poses) if config.estimate_noise else model
            splines = thinned(splines, sights, feet, poses, config.trimming, model.fitting) if half else splines
        graph = build_graph(keys, poses, splines, factors, sights, firm, model, gate)
        if number == 0 and len(graph.control_points):
            graph = replace(graph, control_points=solve_control_points(graph, poses))
        steps = usual_records(name, len(keys)) if last else 6

        def note(record: IterationRecord, number: int = number, steps: int = steps) -> None:
            records.append(replace(record, index=len(records)))
            progress((number + min(record.index, steps - 1) / steps) / len(config.gates), records[-1])

        solver = back_end(name) if last else back_end("direct" if name in IN_ORDER else name, ROUGHLY)
        estimate = solver.solve(graph, progress=note, cancelled=cancelled)
        poses, splines = estimate.poses, with_estimate(splines, estimate)
    assert estimate is not None
    return splines, replace(estimate, iterations=tuple(records))


def usual_records(name: str, key_scans: int) -> int:
    """About how many records a back end tells of in one round."""
    if name in ONE_PASS:
        return records_of(key_scans)
    return JOINING_RECORDS if name == "islsjf" else 6
