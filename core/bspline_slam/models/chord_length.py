"""The paper's model as written: clamped splines of a fixed number of control points, known along the curve as well."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association, Piece, Verdict
from bspline_slam.bspline import BSpline, clamped_between
from bspline_slam.errors import GeometryError
from bspline_slam.fitting import FittingConfig, cumulated_chords, curve_through
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import SplineFactor
from bspline_slam.models.protocol import GrowingMap, SeenBeams, Sight
from bspline_slam.observation import ChordLengthNoise, SplineObservation, chord_length
from bspline_slam.relation import Relation, RelationConfig, SplineRelation, extended, relate

LEAST_POINTS = 4
"""Fewer beams than this are no observation."""
RESAMPLED = 8
"""Points for each control point when a stretch of a curve is fitted again."""
RESAMPLING = 0.1
"""Distance (m) between the points of a spline that its extension must still pass by."""


@dataclass(frozen=True, slots=True)
class ChordLengthConfig:
    """What the paper leaves free: the number of control points of every spline, the angles that decide its relation to
    new data, and the terms of the covariance.

    A spline through few points has one control point for every two of them, at least degree + 1, until more data are
    added to it. The paper takes associations to be right: data whose parameters put a beam farther than `gate` (m) from
    its end are no observation, for bearings alone told their relation wrongly.
    """

    control_points: int = 13
    gate: float = 0.5
    relation: RelationConfig = RelationConfig()
    noise: ChordLengthNoise = ChordLengthNoise()


@dataclass(frozen=True, slots=True)
class ChordLength:
    """Eqs 4–15 and section 4 of the paper.

    A parameter is the paper's t ∈ [0, 1] times the length of the spline, which changes no control point.
    """

    fitting: FittingConfig = FittingConfig()
    config: ChordLengthConfig = field(default_factory=ChordLengthConfig)

    @property
    def measures_along(self) -> bool:
        return True

    def with_noise(self, range_noise: float, bearing_noise: float) -> ChordLength:
        """Itself: the published model is told its noise."""
        return self

    def through(self, points: Float[np.ndarray, "m 2"]) -> BSpline:
        """Chord-length parameters and least squares (eqs 4–10)."""
        t = cumulated_chords(points)
        count = max(min(self.config.control_points, len(points) // 2), self.fitting.degree + 1)
        knots = clamped_between(0.0, float(t[-1]), count, self.fitting.degree)
        return curve_through(points, t, knots, self.fitting)

    def plainest(self, points: Float[np.ndarray, "m 2"], tolerance: float) -> BSpline:
        """The number of control points being fixed, the one curve that there is, whatever the tolerance."""
        return self.through(points)

    def cut(self, curve: BSpline, span: tuple[float, float]) -> BSpline:
        """Derived again: the stretch has all control points to itself then."""
        count = len(curve.control_points)
        t = np.linspace(*span, RESAMPLED * count)
        return curve_through(curve(t), t, clamped_between(*span, count, curve.degree), self.fitting)

    def take_in(self, growing: GrowingMap, sight: Sight, pieces: Sequence[Piece]) -> list[Association]:
        """All that a segment shows of a spline, beams beyond its ends included, is one observation: full, part, or
        extension. Beams that this leaves start a spline."""
        free = {piece.a: piece for piece in pieces if piece.spline is None}
        out: list[Association] = []
        for before, piece, after in _with_neighbours(pieces):
            if piece.spline is None:
                continue
            low = self._carried(growing, sight, piece.spline, free.get(before.a) if before else None, forward=False)
            high = self._carried(growing, sight, piece.spline, free.get(after.a) if after else None, forward=True)
            whole = Piece(low.a if low else piece.a, high.b if high else piece.b, piece.spline)
            decided, taken = self._decided(growing, sight, piece, whole)
            out.append(decided)
            free = {a: one for a, one in free.items() if not taken.a <= a < taken.b}
        out.extend(growing.start(sight, piece) for piece in free.values())
        return sorted(out, key=lambda association: association.first)

    def _carried(
        self, growing: GrowingMap, sight: Sight, spline: int, piece: Piece | None, *, forward: bool
    ) -> Piece | None:
        """The free neighbour of a piece, if the spline carries on through it."""
        if piece is None or not growing.carries_on(spline, sight.points[piece.a : piece.b], forward=forward):
            return None
        return piece

    def _decided(self, growing: GrowingMap, sight: Sight, explained: Piece, whole: Piece) -> tuple[Association, Piece]:
        """The decision and the beams that it is about: the whole, or only the explained ones where the bearings do not
        tell what the whole is, or where so many control points cannot follow the longer spline."""
        relation = None
        for piece in (whole, explained):
            assert piece.spline is not None
            curve = growing.spline(piece.spline).curve
            local = curve.with_control_points(curve.control_points - sight.sensor)
            found = self.related(local, sight.points[piece.a : piece.b] - sight.sensor)
            if found is None:
                continue
            relation = found.relation
            if relation is not Relation.EXTENSION:
                return growing.association(sight, piece, Verdict.MATCHED, relation), piece
            if self._grown(growing, sight, piece, found):
                return growing.association(sight, piece, Verdict.EXTENDED, relation), piece
        if relation is None:
            return growing.association(sight, Piece(explained.a, explained.b, None), Verdict.GATED, None), explained
        return growing.association(sight, explained, Verdict.MATCHED, relation), explained

    def _grown(self, growing: GrowingMap, sight: Sight, piece: Piece, found: SplineRelation) -> bool:
        """The control points derived again for the extended full spline, if they can follow it."""
        assert piece.spline is not None
        full_spline, points = growing.spline(piece.spline), sight.points[piece.a : piece.b]
        curve = extended(full_spline.curve, points, found, self.config.control_points, self.fitting)
        _, on = found.placed(full_spline.curve, points)
        to_follow = np.concatenate([full_spline.sample(RESAMPLING)[1], points[~on]])
        return growing.grow(piece.spline, curve, curve.domain, to_follow, sight.scan)

    def observe(self, curves: Sequence[BSpline], poses: Float[np.ndarray, "p 3"], beams: SeenBeams) -> FlatFactors:
        """Control points by least squares at the parameters of section 4.2, with P = P_s + P_t1 + P_t2 (eq. 15).

        The full spline is as long as the map says: beams beyond its ends are left out.
        """
        points = np.split(beams.points, beams.cuts[1:-1])
        told = enumerate(map(self._observed, curves, poses, points, beams.sensors))
        return FlatFactors.of(
            [SplineFactor(k, one.first, one.A, one.b, one.readings, one.constant) for k, one in told if one is not None]
        )

    def _observed(
        self,
        curve: BSpline,
        pose: Float[np.ndarray, "3"],
        points: Float[np.ndarray, "m 2"],
        sensor: Float[np.ndarray, "2"],
    ) -> SplineObservation | None:
        if len(points) < LEAST_POINTS:
            return None
        points = points - sensor
        local = curve.with_control_points(se2.transform(se2.inverse(pose), curve.control_points) - sensor)
        found = self.related(local, points)
        if found is None:
            return None
        t, on = found.placed(local, points)
        if np.count_nonzero(on) < LEAST_POINTS:
            return None
        return chord_length(local, t[on], points[on], self.fitting, self.config.noise).moved(sensor)

    def related(self, curve: BSpline, points: Float[np.ndarray, "m 2"]) -> SplineRelation | None:
        """Full, part or extension (section 4.1) in the frame of the sensor; None when the bearings do not tell."""
        try:
            found = relate(curve, points, self.config.relation)
        except GeometryError:
            return None
        t, on = found.placed(curve, points)
        off = np.linalg.norm(curve(t[on]) - points[on], axis=1)
        return found if off.max(initial=0.0) < self.config.gate else None


def _with_neighbours(pieces: Sequence[Piece]) -> Iterator[tuple[Piece | None, Piece, Piece | None]]:
    """Each piece with the one before and the one after it."""
    yield from zip([None, *pieces[:-1]], pieces, [*pieces[1:], None], strict=True)
