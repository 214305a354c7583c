"""The observation that a person steps through: the selected segment of the current key scan, taken apart."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.errors import GeometryError
from bspline_slam.observation import MODELS
from bspline_slam.observation_steps import ObservationSteps, ObservedRelation, observation_steps, observed_relation
from bspline_slam.relation import RelationConfig
from bspline_slam.segmentation import ScanSegment
from bspline_slam.slam import SlamConfig
from splinescope.view import MapView, ScanView, Selection

CHORD_LENGTH = MODELS[1]


class ObservationStep(Enum):
    """From beams to a decision; the value is the heading of the step."""

    PARAMETERS = "Points and chord-length parameters"
    BASIS = "Rows of the basis matrix"
    CONTROL_POINTS = "Fitted control points"
    COVARIANCE = "Contributions to the covariance"
    RELATION = "Relation to its spline"

    @property
    def number(self) -> int:
        """Counted from 1."""
        return list(ObservationStep).index(self) + 1

    def moved(self, by: int) -> ObservationStep:
        """The step `by` further on, as far as there is one."""
        steps = list(ObservationStep)
        return steps[min(max(self.number - 1 + by, 0), len(steps) - 1)]


@dataclass(frozen=True, eq=False, slots=True)
class ObservationView:
    """One segment with its steps (sensor frame, which `pose` places in the world), in a run with this `model`.

    `association` is the decision about its piece number `piece` of `pieces`, the longest first; `relation` is what
    that piece is to its spline as the map has it now, or a sentence on why that cannot be told.
    """

    scan: int
    model: str
    segment: ScanSegment
    pose: Float[np.ndarray, "3"]
    steps: ObservationSteps
    association: Association | None
    piece: int
    pieces: int
    relation: ObservedRelation | str


def view_observation(
    scan: ScanView | None, world: MapView | None, selection: Selection | None, config: SlamConfig
) -> ObservationView | str:
    """The selected segment step by step, or a sentence on what is missing.

    `selection.sub` chooses among its pieces, `config` is that of the run.
    """
    if scan is None:
        return "No scan is shown."
    if not scan.key:
        return f"Scan {scan.scan.index} is not a key scan: nothing of it is observed. Go to a key scan first."
    if not scan.segments:
        return f"Key scan {scan.scan.index} has no segment: too few of its beams came back."
    if selection is None or selection.kind != "segment":
        return "No segment is selected. Click one in the map, or take one by its button here."
    segment = next((f.segment for f in scan.segments if f.segment.index == selection.id), None)
    if segment is None:
        return f"Key scan {scan.scan.index} has no segment {selection.id}."
    return _taken_apart(scan, segment, world, selection.sub, config)


def _taken_apart(
    scan: ScanView, segment: ScanSegment, world: MapView | None, piece: int, config: SlamConfig
) -> ObservationView | str:
    sensor = scan.scan.pose_robot_sensor
    try:
        points = se2.transform(se2.inverse(sensor), segment.points)
        steps = observation_steps(points, config.fitting, config.chord_length.noise, control_points_of(config))
    except GeometryError as error:
        return f"Segment {segment.index} cannot be observed: {error}."
    mine = sorted(
        (association for association in scan.associations if association.segment == segment.index),
        key=lambda association: association.first - association.last,
    )
    chosen = mine[piece % len(mine)] if mine else None
    pose = se2.compose(scan.pose, sensor)
    relation = _relation(steps, segment, chosen, world, pose, config.chord_length.relation)
    return ObservationView(
        scan.scan.index,
        config.model,
        segment,
        pose,
        steps,
        chosen,
        piece % len(mine) if mine else 0,
        len(mine),
        relation,
    )


def control_points_of(config: SlamConfig) -> int | None:
    """How many control points the observation is of; None where the length of the segment decides."""
    return config.chord_length.control_points if config.model == CHORD_LENGTH else None


def _relation(
    steps: ObservationSteps,
    segment: ScanSegment,
    association: Association | None,
    world: MapView | None,
    pose: Float[np.ndarray, "3"],
    config: RelationConfig,
) -> ObservedRelation | str:
    """What a piece of the segment is to the spline it was given to."""
    if association is None:
        return "Nothing was decided about this segment, so there is no spline to hold it against."
    if association.spline is None:
        why = "it lies too far from every spline" if association.verdict is Verdict.GATED else "it was left out"
        return f"The segment was given to no spline ({why}), so there is nothing to hold it against."
    if world is None or association.spline not in world.map:
        return f"Spline {association.spline} is not in the map any more: too few key scans saw it."
    spline = world.map[association.spline]
    low, high = spline.curve.domain
    whole = spline.curve.clamped((max(spline.span[0], low), min(spline.span[1], high)))
    whole = whole.moved(se2.inverse(pose))
    beams = (segment.beams >= association.first) & (segment.beams <= association.last)
    points = steps.points[beams]
    if len(points) < 2:
        return "The piece has a single beam: two are needed to compare ends."
    try:
        return observed_relation(whole, points, config)
    except GeometryError as error:
        return f"It cannot be told: {error}."
