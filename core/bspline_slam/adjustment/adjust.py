"""Spline adjustment: the graph derived from decisions, solved, with new foot points each round, until nothing
moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.adjustment.corner_joints import walls_in_turn, with_corners
from bspline_slam.adjustment.spline_graph import build_graph
from bspline_slam.adjustment.trimming import agreed, thinned, trimmed
from bspline_slam.backends import IN_ORDER, ONE_PASS, Stopping, back_end, solve_control_points
from bspline_slam.backends.islsjf import JOINING_RECORDS
from bspline_slam.backends.one_pass import records_of
from bspline_slam.backends.protocol import BackEnd, Cancelling, Estimate, IterationRecord, never
from bspline_slam.calibration.laser_noise import calibrated
from bspline_slam.corners import Joint, meeting
from bspline_slam.errors import Cancelled
from bspline_slam.graph import Graph, PoseFactor
from bspline_slam.models.protocol import Model
from bspline_slam.sights import KeyObservations, Sights, collect_sights, find_feet, renumbered
from bspline_slam.spline_map import SplineMap


def with_estimate(splines: SplineMap, estimate: Estimate) -> SplineMap:
    """The map with the control points of an estimate; splines that were not in the graph are gone."""
    return with_control_points(splines, estimate.graph, estimate.control_points)


def with_control_points(splines: SplineMap, graph: Graph, control_points: Float[np.ndarray, "N 2"]) -> SplineMap:
    """The map with the control points of a graph; splines that are not in the graph are gone."""
    by_id = {spline.id: spline for spline in splines}
    out = []
    for k, spline_id in enumerate(graph.spline_ids):
        spline = by_id[int(spline_id)]
        a, b = graph.spline_first[k], graph.spline_first[k + 1]
        out.append(replace(spline, curve=spline.curve.with_control_points(control_points[a:b])))
    return SplineMap(tuple(out))


ROUGHLY = Stopping(decrease=1e-3, move=1e-2, iterations=2)
"""Rounds before the last find new foot points anyway."""

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
    joints: tuple[Joint, ...] = ()
    sights = collect_sights(keys, splines)
    for number, gate in enumerate(config.gates):
        if cancelled():
            raise Cancelled("the adjustment was cancelled")
        splines, sights = _trimmed(splines, sights, poses, gate, config, model)
        last, half = number + 1 == len(config.gates), number == len(config.gates) // 2
        if (half or last) and not model.measures_along:
            feet = find_feet(sights, splines, poses, gate)
            model = calibrated(model, splines, sights, feet, poses) if config.estimate_noise else model
            before, seen = splines, (sights, feet, poses, config.trimming, model.fitting)
            splines = agreed(thinned(splines, *seen) if half else splines, *seen)
            if last:
                followed = walls_in_turn(before, sights, feet, config.trimming)
                splines, joints = with_corners(splines, followed, config.trimming, model)
            sights = renumbered(sights, before, splines)
        graph = build_graph(keys, poses, splines, factors, sights, config, model, gate)
        graph = _with_fitted_curves(graph) if number == 0 else graph
        steps = usual_records(name, len(keys)) if last else 6

        def note(record: IterationRecord, number: int = number, steps: int = steps) -> None:
            records.append(replace(record, index=len(records)))
            progress((number + min(record.index, steps - 1) / steps) / len(config.gates), records[-1])

        solver = back_end(name) if last else _on_the_way(name)
        estimate = solver.solve(graph, progress=note, cancelled=cancelled)
        before, poses, splines = splines, estimate.poses, with_estimate(splines, estimate)
        sights = renumbered(sights, before, splines)
    assert estimate is not None
    return meeting(splines, joints), replace(estimate, iterations=tuple(records))


@dataclass(frozen=True, eq=False, slots=True)
class Foreseen:
    """A rough estimate, with the map and the sights that its graph was made of, and the gate of their feet (m)."""

    estimate: Estimate
    splines: SplineMap
    sights: Sights
    gate: float


def foreseen(
    keys: Sequence[KeyObservations],
    poses: Float[np.ndarray, "n 3"],
    splines: SplineMap,
    factors: Sequence[PoseFactor],
    config: AdjustmentConfig,
    model: Model,
    name: str,
    cancelled: Cancelling = never,
) -> Foreseen:
    """About where `adjust_splines` is going to put poses and curves: its first round, solved roughly. Raises
    Cancelled."""
    sights, gate = collect_sights(keys, splines), config.gates[0]
    splines, sights = _trimmed(splines, sights, poses, gate, config, model)
    graph = _with_fitted_curves(build_graph(keys, poses, splines, factors, sights, config, model, gate))
    return Foreseen(_on_the_way(name).solve(graph, cancelled=cancelled), splines, sights, gate)


def _trimmed(
    splines: SplineMap,
    sights: Sights,
    poses: Float[np.ndarray, "n 3"],
    gate: float,
    config: AdjustmentConfig,
    model: Model,
) -> tuple[SplineMap, Sights]:
    """The map trimmed as these poses see it, and its sights."""
    beyond = 0.0 if model.measures_along else config.trimming.reach
    kept = trimmed(splines, sights, find_feet(sights, splines, poses, gate, beyond), config.trimming, model)
    return kept, renumbered(sights, splines, kept)


def _with_fitted_curves(graph: Graph) -> Graph:
    """The graph with control points that fit the poses it begins with."""
    if len(graph.control_points) == 0:
        return graph
    return replace(graph, control_points=solve_control_points(graph, graph.poses))


def _on_the_way(name: str) -> BackEnd:
    """What solves the rounds before the last of a back end."""
    return back_end("direct" if name in IN_ORDER else name, ROUGHLY)


def usual_records(name: str, key_scans: int) -> int:
    """About how many records a back end tells of in one round."""
    if name in ONE_PASS:
        return records_of(key_scans)
    return JOINING_RECORDS if name == "islsjf" else 6
