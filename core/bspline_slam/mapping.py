"""The map under construction: segments find their splines, lengthen them, join them, or start new ones."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import (
    Association,
    AssociationConfig,
    Explanation,
    Piece,
    Relation,
    Verdict,
    candidates_of,
    cut_into_pieces,
)
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig, cumulated_chords, second_differences, uniform_through
from bspline_slam.kernels import matching as kernels
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import MapSpline, SplineMap

SAMPLE_SPACING = 0.05
BUCKET = 0.3


@dataclass(eq=False, slots=True)
class _Sampled:
    """A spline with its cached samples."""

    spline: MapSpline
    t: Float[np.ndarray, "s"]
    points: Float[np.ndarray, "s 2"]
    normals: Float[np.ndarray, "s 2"]
    box: Float[np.ndarray, "4"]


def _sampled(spline: MapSpline) -> _Sampled:
    t, points = spline.sample(SAMPLE_SPACING)
    box = np.concatenate([points.min(0) - BUCKET, points.max(0) + BUCKET])
    return _Sampled(spline, t, points, spline.curve.normals(t), box)


@dataclass
class MapBuilder:
    """State of the map: its splines, and which id lives on in which after joins (`heirs`).

    `inherited(scan, segment)` names the id that a spline started there should take again, −1 for a new one.
    """

    config: AssociationConfig
    fitting: FittingConfig
    inherited: Callable[[int, int], int] | None = None
    first_id: int = 0
    heirs: dict[int, int] = field(default_factory=dict)
    _splines: dict[int, _Sampled] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.next_id = self.first_id

    # -- reading -----------------------------------------------------------------------------------------------
    @property
    def map(self) -> SplineMap:
        """The map as a value."""
        return SplineMap(tuple(self._splines[k].spline for k in sorted(self._splines)))

    def heir(self, spline: int) -> int:
        """The id under which a spline lives now."""
        while spline in self.heirs:
            spline = self.heirs[spline]
        return spline

    # -- the step ----------------------------------------------------------------------------------------------
    def add(self, scan: int, pose: Float[np.ndarray, "3"], segments: Sequence[ScanSegment]) -> tuple[Association, ...]:
        """Associate the segments of a key scan at its pose, and let the map grow by them."""
        if not segments:
            return ()
        seen = self._explain(pose, segments)
        decided: list[Association] = []
        for segment, one in zip(segments, seen, strict=True):
            decided.extend(self._decide(scan, pose, segment, one))
        self._join_neighbours(scan, decided)
        for spline in {a.spline for a in decided if a.spline is not None}:
            held = self._splines[self.heir(spline)]
            held.spline = replace(held.spline, observations=held.spline.observations + 1)
        return tuple(replace(a, spline=None if a.spline is None else self.heir(a.spline)) for a in decided)

    def _explain(self, pose: Float[np.ndarray, "3"], segments: Sequence[ScanSegment]) -> list[Explanation]:
        """For each segment the splines near each of its points."""
        points = se2.transform(pose, np.concatenate([s.points for s in segments]))
        normals = se2.rotate(pose, np.concatenate([left_normals(s.points) for s in segments]))
        found = self.near(points, normals)
        cuts = np.cumsum([len(s.points) for s in segments])[:-1]
        parts = zip(*(np.split(column, cuts) for column in (found.spline, found.t, found.across)), strict=True)
        return [Explanation(*part) for part in parts]

    def near(self, points: Float[np.ndarray, "m 2"], normals: Float[np.ndarray, "m 2"]) -> Explanation:
        """The splines that explain each world point, nearest first."""
        low, high = points.min(0), points.max(0)
        close = [
            s
            for s in self._splines.values()
            if s.box[0] <= high[0] and s.box[1] <= high[1] and s.box[2] >= low[0] and s.box[3] >= low[1]
        ]
        shape = (len(points), self.config.candidates)
        if not close:
            return Explanation(np.full(shape, -1), np.zeros(shape), np.zeros(shape))
        samples = np.concatenate([s.points for s in close])
        sample_normals = np.concatenate([s.normals for s in close])
        sample_t = np.concatenate([s.t for s in close])
        owner = np.repeat([s.spline.id for s in close], [len(s.t) for s in close])
        origin = samples.min(0) - BUCKET
        grid = np.ceil((samples.max(0) - origin) / BUCKET).astype(np.int64) + 1
        start, order = kernels.bucket_points(samples, origin, grid, BUCKET)
        found = kernels.facing_candidates(
            points, normals, samples, sample_normals, owner, start, order, origin, grid, BUCKET,
            max(self.config.gate, self.config.along), self.config.agreement, self.config.candidates,
        )  # fmt: skip
        hit = np.maximum(found, 0)
        off = points[:, None] - samples[hit]
        across = (off * sample_normals[hit]).sum(-1)
        along = off[..., 0] * sample_normals[hit][..., 1] - off[..., 1] * sample_normals[hit][..., 0]
        good = (found >= 0) & (np.abs(across) < self.config.gate) & (np.abs(along) < self.config.along)
        return Explanation(np.where(good, owner[hit], -1), sample_t[hit] + along, across)

    # -- decisions ---------------------------------------------------------------------------------------------
    def _decide(
        self, scan: int, pose: Float[np.ndarray, "3"], segment: ScanSegment, seen: Explanation
    ) -> list[Association]:
        world = se2.transform(pose, segment.points)
        pieces = self._smooth_pieces(cut_into_pieces(seen, self.config), segment.points)
        out: list[Association] = []
        for k, piece in enumerate(pieces):
            placed, verdict = piece, Verdict.MATCHED
            if piece.spline is None:
                placed, verdict = self._place_unexplained(scan, segment, world, seen, pieces, k)
            out.append(self._association(scan, segment, seen, placed, verdict))
        return out

    def _smooth_pieces(self, pieces: Sequence[Piece], points: Float[np.ndarray, "m 2"]) -> list[Piece]:
        """Unexplained pieces cut at sparse places, and until each is one smooth curve at the configured spacing."""
        out: list[Piece] = []
        for piece in pieces:
            if piece.spline is not None:
                out.append(piece)
                continue
            for a, b in itertools.pairwise(sparse_cuts(points[piece.a : piece.b], self.config)):
                dense = points[piece.a + a : piece.a + b]
                cuts = [piece.a + a + k for k in smooth_cuts(dense, self.fitting, self.config.smooth)]
                out.extend(Piece(start, end, None) for start, end in itertools.pairwise(cuts))
        return out

    def _place_unexplained(
        self,
        scan: int,
        segment: ScanSegment,
        world: Float[np.ndarray, "m 2"],
        seen: Explanation,
        pieces: Sequence[Piece],
        k: int,
    ) -> tuple[Piece, Verdict]:
        """Beams that no spline explains lengthen a neighbour that ends there, or start a spline, or are left out."""
        piece = pieces[k]
        points = world[piece.a : piece.b]
        if k > 0:
            spline = pieces[k - 1].spline
            if spline is not None and self._extend(spline, points, scan, forward=True):
                return Piece(piece.a, piece.b, spline), Verdict.EXTENDED
        if k + 1 < len(pieces):
            spline = pieces[k + 1].spline
            if spline is not None and self._extend(spline, points, scan, forward=False):
                return Piece(piece.a, piece.b, spline), Verdict.EXTENDED
        long_enough = cumulated_chords(points)[-1] >= self.config.new_length
        if piece.b - piece.a >= self.config.new_points and long_enough:
            return Piece(piece.a, piece.b, self._start(scan, segment.index, points)), Verdict.NEW
        return piece, Verdict.GATED

    def _association(
        self, scan: int, segment: ScanSegment, seen: Explanation, piece: Piece, verdict: Verdict
    ) -> Association:
        candidates = candidates_of(seen.part(piece.a, piece.b))
        chosen = next((c for c in candidates if c.spline == piece.spline), None)
        relation = None
        if piece.spline is not None:
            relation = Relation.EXTENSION if verdict is Verdict.EXTENDED else self._relation(seen, piece)
        first, last = int(segment.beams[piece.a]), int(segment.beams[piece.b - 1])
        distance = chosen.distance if chosen else float("nan")
        return Association(
            scan, segment.index, first, last, verdict, piece.spline, distance, self.config.gate, candidates, relation
        )

    def _relation(self, seen: Explanation, piece: Piece) -> Relation:
        """Full when the piece reaches both ends of its spline, part otherwise."""
        assert piece.spline is not None
        explained, t, _ = seen.part(piece.a, piece.b).of(piece.spline)
        if not explained.any():
            return Relation.FULL
        low, high = self._splines[self.heir(piece.spline)].spline.span
        reached = t[explained]
        full = reached.min() - low < self.config.extension and high - reached.max() < self.config.extension
        return Relation.FULL if full else Relation.PART

    # -- growth ------------------------------------------------------------------------------------------------
    def _start(self, scan: int, segment: int, points: Float[np.ndarray, "m 2"]) -> int:
        curve = uniform_through(points, self.fitting)
        inherited = self.inherited(scan, segment) if self.inherited else -1
        taken = inherited in self._splines or inherited in self.heirs
        new = self.next_id if inherited < 0 or taken else inherited
        self.next_id = max(self.next_id, new + 1)
        length = float(cumulated_chords(points)[-1])
        self._splines[new] = _sampled(
            MapSpline(new, curve, (0.0, length), scan, 0, (f"started by scan {scan}, {length:.2f} m",))
        )
        return new

    def _extend(self, spline: int, points: Float[np.ndarray, "m 2"], scan: int, *, forward: bool) -> bool:
        """Lengthen a spline through points beyond its end (or start), if they carry on from there."""
        held = self._splines[spline]
        if not self._carries_on(held.spline, points, forward=forward):
            return False
        curve, span = lengthened(held.spline, points, self.fitting, forward=forward)
        gain = (span[1] - span[0]) - (held.spline.span[1] - held.spline.span[0])
        if gain <= 0.0 or largest_distance(curve, span, points) > self.config.smooth:
            return False
        history = (*held.spline.history, f"grew by {gain:.2f} m at scan {scan}")
        self._splines[spline] = _sampled(replace(held.spline, curve=curve, span=span, history=history))
        return True

    def _carries_on(self, spline: MapSpline, points: Float[np.ndarray, "m 2"], *, forward: bool) -> bool:
        """Whether points lie beyond the end of a curve, near it, and in its direction."""
        t = spline.span[1] if forward else spline.span[0]
        end = spline.curve(np.array([t]))[0]
        out = spline.curve(np.array([t]), 1)[0] * (1.0 if forward else -1.0)
        off = (points if forward else points[::-1]) - end
        away = np.linalg.norm(off, axis=1)
        bend = np.arccos(np.clip(off @ out / (away * np.linalg.norm(out) + 1e-12), -1.0, 1.0))
        beyond = away > self.config.along
        if not beyond.any():
            return False
        return bool(away[0] < self.config.extension and bend[beyond][0] < self.config.join_turn)

    def _join_neighbours(self, scan: int, decided: Sequence[Association]) -> None:
        """Two splines that one segment shows to follow each other become one; the older id lives on."""
        for before, after in itertools.pairwise(decided):
            if before.segment != after.segment or before.spline is None or after.spline is None:
                continue
            a, b = self.heir(before.spline), self.heir(after.spline)
            if a != b and self._meet(self._splines[a].spline, self._splines[b].spline):
                self._join(a, b, scan)

    def _meet(self, a: MapSpline, b: MapSpline) -> bool:
        end, start = a.curve(np.array([a.span[1]]))[0], b.curve(np.array([b.span[0]]))[0]
        out, into = a.curve(np.array([a.span[1]]), 1)[0], b.curve(np.array([b.span[0]]), 1)[0]
        bend = np.arccos(np.clip(out @ into / (np.linalg.norm(out) * np.linalg.norm(into) + 1e-12), -1, 1))
        return bool(np.linalg.norm(start - end) < self.config.join_gap and bend < self.config.join_turn)

    def _join(self, a: int, b: int, scan: int) -> None:
        """Join b to the end of a under the lower id."""
        first, second = self._splines.pop(a), self._splines.pop(b)
        forward = ((second.points - first.points[-1]) * (first.points[-1] - first.points[-2])).sum(1) > 0
        points = np.concatenate([first.points, second.points[forward]])
        curve = uniform_through(points, self.fitting)
        if largest_distance(curve, curve.domain, points) > self.config.smooth:
            self._splines[a], self._splines[b] = first, second
            return
        keep, gone = min(a, b), max(a, b)
        held = self._splines_value(first.spline, second.spline, keep)
        history = (*held.history, f"joined spline {gone} at scan {scan}")
        span = (0.0, float(cumulated_chords(points)[-1]))
        self._splines[keep] = _sampled(replace(held, curve=curve, span=span, history=history))
        self.heirs[gone] = keep

    @staticmethod
    def _splines_value(a: MapSpline, b: MapSpline, keep: int) -> MapSpline:
        older = a if a.id == keep else b
        return replace(older, born=min(a.born, b.born), observations=max(a.observations, b.observations))


def largest_distance(curve: BSpline, span: tuple[float, float], points: Float[np.ndarray, "m 2"]) -> float:
    """Largest distance of points to a stretch of curve, to the nearest centimetre of arc (m)."""
    _, samples = curve.sample(0.01, span)
    return float(np.sqrt(((points[:, None] - samples[None]) ** 2).sum(-1).min(1).max()))


def sparse_cuts(points: Float[np.ndarray, "m 2"], config: AssociationConfig) -> list[int]:
    """Where to cut a run (robot frame) because the surface between two beam ends is anybody's guess: they lie farther
    apart than `sparse_gap` and than `sparse_ratio` times what a wall facing the robot would give."""
    gap = np.linalg.norm(np.diff(points, axis=0), axis=1)
    across = np.abs(points[:-1, 0] * points[1:, 1] - points[:-1, 1] * points[1:, 0])
    facing = across / np.maximum(np.linalg.norm(points[:-1], axis=1), 1e-9)
    wide = (gap > config.sparse_gap) & (gap > config.sparse_ratio * facing)
    return [0, *(int(k) + 1 for k in np.flatnonzero(wide)), len(points)]


def smooth_cuts(points: Float[np.ndarray, "m 2"], fitting: FittingConfig, tolerance: float) -> list[int]:
    """Where to cut a run so that a curve at the configured knot spacing stays within `tolerance` of every point (m)."""
    m = len(points)
    if m < 4 or cumulated_chords(points)[-1] < 1e-6:
        return [0, m]
    curve = uniform_through(points, fitting)
    off = np.linalg.norm(curve(cumulated_chords(points)) - points, axis=1)
    worst = int(np.argmax(off))
    if off[worst] <= tolerance:
        return [0, m]
    cut = min(max(worst, 2), m - 2)
    left = smooth_cuts(points[:cut], fitting, tolerance)
    right = smooth_cuts(points[cut:], fitting, tolerance)
    return [*left, *(cut + k for k in right[1:])]


def left_normals(points: Float[np.ndarray, "m 2"], reach: int = 3) -> Float[np.ndarray, "m 2"]:
    """Unit normals of a polygon, its chord over ±`reach` points turned left (towards the robot, for a segment)."""
    index = np.arange(len(points))
    chord = points[np.minimum(index + reach, len(points) - 1)] - points[np.maximum(index - reach, 0)]
    chord = chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-12)
    return np.stack([-chord[:, 1], chord[:, 0]], -1)


def lengthened(
    spline: MapSpline, points: Float[np.ndarray, "m 2"], fitting: FittingConfig, *, forward: bool
) -> tuple[BSpline, tuple[float, float]]:
    """The curve grown through `points` beyond its end (or before its start): control points are appended, and only
    those that shape the old end or the new stretch are solved for again."""
    if not forward:
        turned = replace(spline, curve=spline.curve.reversed(), span=_mirrored(spline.curve, spline.span))
        grown, span = lengthened(turned, points[::-1], fitting, forward=True)
        back, span = grown.reversed(), _mirrored(grown, span)
        shift = back.domain[1] - spline.curve.domain[1]
        return BSpline(back.degree, back.knots - shift, back.control_points), (span[0] - shift, span[1] - shift)
    curve, (low, high) = spline.curve, spline.span
    spacing = float(curve.knots[curve.degree + 1] - curve.knots[curve.degree])
    end = curve(np.array([high]))[0]
    ahead = ((points - end) * curve(np.array([high]), 1)[0]).sum(1) > 0
    points = points[ahead]
    if len(points) == 0:
        return curve, spline.span
    t_new = high + cumulated_chords(np.concatenate([end[None], points]))[1:]
    reach = float(t_new[-1])
    grown = curve.extended(after=max(int(np.ceil((reach - curve.domain[1]) / spacing - 1e-9)), 0))
    free = np.flatnonzero(grown.knots[np.arange(len(grown.control_points)) + grown.degree + 1] > high - 1e-9)
    t_old = np.linspace(max(low, high - 3 * spacing), high, 16)
    B = grown.basis(np.concatenate([t_old, t_new]))
    right = np.concatenate([curve(t_old), points])
    D = second_differences(len(grown.control_points))[:, :] * 0.05
    D = D[(D[:, free] != 0).any(1)]
    fixed = np.setdiff1d(np.arange(len(grown.control_points)), free)
    c = grown.control_points.copy()
    M = np.concatenate([B[:, free], D[:, free]])
    y = np.concatenate([right - B[:, fixed] @ c[fixed], -D[:, fixed] @ c[fixed]])
    c[free] = np.linalg.lstsq(M, y, rcond=None)[0]
    return grown.with_control_points(c), (low, reach)


def _mirrored(curve: BSpline, span: tuple[float, float]) -> tuple[float, float]:
    total = float(curve.knots[0] + curve.knots[-1])
    return total - span[1], total - span[0]
