"""The tangent-free model: curves that grow by appending control points, beams that measure across them alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association, Piece, Verdict
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig, cumulated_chords, uniform_through
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.front_end.growth import lengthened
from bspline_slam.kernels import curves as kernels
from bspline_slam.models.protocol import GrowingMap, SeenBeams, Sight
from bspline_slam.relation import Relation

NARROWEST = 0.1
"""Knots closer than this (m) are not tried."""


@dataclass(frozen=True, slots=True)
class NormalDistance:
    """Uniform knots a fixed distance apart, so that the basis does not depend on what was seen."""

    fitting: FittingConfig = FittingConfig()

    @property
    def measures_along(self) -> bool:
        return False

    def with_noise(self, range_noise: float, bearing_noise: float) -> NormalDistance:
        return replace(self, fitting=replace(self.fitting, range_noise=range_noise, bearing_noise=bearing_noise))

    def through(self, points: Float[np.ndarray, "m 2"]) -> BSpline:
        return uniform_through(points, self.fitting)

    def plainest(self, points: Float[np.ndarray, "m 2"], tolerance: float) -> BSpline:
        """The widest knots that will do."""
        length = float(cumulated_chords(points)[-1])
        pieces = 1
        while True:
            curve = uniform_through(points, replace(self.fitting, spacing=length / pieces * (1 + 1e-9)))
            t = curve.foot_points(points)
            off = np.abs(((curve(t) - points) * curve.normals(t)).sum(1)).max()
            if off < tolerance or length / pieces < NARROWEST:
                return curve
            pieces = int(np.ceil(1.4 * pieces))

    def cut(self, curve: BSpline, span: tuple[float, float]) -> BSpline:
        return curve.restricted(span)

    def take_in(self, growing: GrowingMap, sight: Sight, pieces: Sequence[Piece]) -> list[Association]:
        """What a spline explains is matched to it; other beams lengthen a neighbour, or start a spline."""
        out: list[Association] = []
        for k, piece in enumerate(pieces):
            if piece.spline is not None:
                relation = _reach(growing, sight, piece)
                out.append(growing.association(sight, piece, Verdict.MATCHED, relation))
            elif (longer := self._lengthened(growing, sight, pieces, k)) is not None:
                out.append(growing.association(sight, longer, Verdict.EXTENDED, Relation.EXTENSION))
            else:
                out.append(growing.start(sight, piece))
        return out

    def _lengthened(self, growing: GrowingMap, sight: Sight, pieces: Sequence[Piece], k: int) -> Piece | None:
        """Beams that no spline explains given to a neighbouring spline that ends there and carries on through them."""
        a, b = pieces[k].a, pieces[k].b
        points = sight.points[a:b]
        for neighbour, forward in ((k - 1, True), (k + 1, False)):
            spline = pieces[neighbour].spline if 0 <= neighbour < len(pieces) else None
            if spline is None or not growing.carries_on(spline, points, forward=forward):
                continue
            curve, span = lengthened(growing.spline(spline), points, self.fitting, forward=forward)
            if growing.grow(spline, curve, span, points, sight.scan):
                return Piece(a, b, spline)
        return None

    def observe(self, curves: Sequence[BSpline], poses: Float[np.ndarray, "p 3"], beams: SeenBeams) -> FlatFactors:
        """r_j = n_jᵀ(Σ_i β_i(t_j) q_i − p_j) for every beam, compressed by one QR for each association."""
        orders = np.array([curve.degree + 1 for curve in curves], dtype=np.int64)
        low, rows, columns = kernels.piece_sizes(beams.cuts, orders, beams.first)
        A, b, constants = kernels.compressed_pieces(
            beams.cuts, orders, beams.first, beams.basis, beams.normals, beams.right, beams.weight, low, rows, columns
        )
        size = np.column_stack([rows, columns // 2])
        return FlatFactors.laid_out(np.arange(len(curves)), low, size, A, b, np.diff(beams.cuts), constants)


def _reach(growing: GrowingMap, sight: Sight, piece: Piece) -> Relation:
    """Full when the piece reaches both ends of its spline, part otherwise."""
    assert piece.spline is not None
    first, last = sight.seen.reach_of(piece.spline, piece.a, piece.b)
    low, high = growing.spline(piece.spline).span
    near = growing.config.extension
    return Relation.PART if first - low >= near or high - last >= near else Relation.FULL
