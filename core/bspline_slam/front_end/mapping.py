"""The map under construction: segments find their splines, lengthen them, join them, or start new ones."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.association import (
    Association,
    AssociationConfig,
    Explanation,
    Piece,
    Verdict,
    candidates_of,
    cut_into_pieces,
)
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import cumulated_chords
from bspline_slam.front_end.growth import largest_distance, left_normals, smooth_cuts, sparse_cuts
from bspline_slam.front_end.samples import Samples
from bspline_slam.models.protocol import Model, Sight
from bspline_slam.relation import Relation
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import MapSpline, SplineMap

SAMPLE_SPACING = 0.05
CENTRE = np.zeros(2)


@dataclass(eq=False, slots=True)
class _Held:
    """A spline with samples of it, and the key scans that saw it (by scan index), which count as its observations."""

    spline: MapSpline
    points: Float[np.ndarray, "s 2"]
    normals: Float[np.ndarray, "s 2"]
    seen_by: set[int]

    def end(self, *, forward: bool) -> tuple[Float[np.ndarray, "2"], Float[np.ndarray, "2"]]:
        """The last point of the curve (or its first) and the unit direction in which it leaves there."""
        k = -1 if forward else 0
        across = self.normals[k] if forward else -self.normals[k]
        return self.points[k], np.array([across[1], -across[0]])


@dataclass
class MapBuilder:
    """State of the map: its splines, and which id lives on in which after joins (`heirs`).

    `inherited(scan, segment)` names the id that a spline started there should take again, −1 for a new one.
    """

    config: AssociationConfig
    model: Model
    inherited: Callable[[int, int], int] | None = None
    first_id: int = 0
    heirs: dict[int, int] = field(default_factory=dict)
    _splines: dict[int, _Held] = field(default_factory=dict)
    _samples: Samples = field(default_factory=Samples)

    def __post_init__(self) -> None:
        self.next_id = self.first_id

    # -- reading -----------------------------------------------------------------------------------------------
    @property
    def map(self) -> SplineMap:
        """The map as a value."""
        held = (self._splines[k] for k in sorted(self._splines))
        return SplineMap(tuple(replace(one.spline, observations=len(one.seen_by)) for one in held))

    def heir(self, spline: int) -> int:
        """The id under which a spline lives now."""
        while spline in self.heirs:
            spline = self.heirs[spline]
        return spline

    # -- the step ----------------------------------------------------------------------------------------------
    def add(
        self,
        scan: int,
        pose: Float[np.ndarray, "3"],
        segments: Sequence[ScanSegment],
        sensor: Float[np.ndarray, "2"] = CENTRE,
    ) -> tuple[Association, ...]:
        """Associate the segments of a key scan at its pose, and let the map grow by them; `sensor` in the robot
        frame."""
        if not segments:
            return ()
        seat = se2.transform(pose, sensor[None])[0]
        decided: list[Association] = []
        for segment, points, seen in self._explained(pose, segments):
            decided.extend(self._decide(Sight(scan, segment, points, seat, seen)))
        self._join_neighbours(scan, decided)
        for spline in {a.spline for a in decided if a.spline is not None}:
            self._splines[self.heir(spline)].seen_by.add(scan)
        return tuple(map(self.renamed, decided))

    def renamed(self, association: Association) -> Association:
        """An association with the id that its spline has after joins."""
        if association.spline is None or association.spline not in self.heirs:
            return association
        return replace(association, spline=self.heir(association.spline))

    def _explained(
        self, pose: Float[np.ndarray, "3"], segments: Sequence[ScanSegment]
    ) -> Iterator[tuple[ScanSegment, Float[np.ndarray, "m 2"], Explanation]]:
        """Each segment with its points in the world, and the splines near each of them."""
        points, sizes = np.concatenate([s.points for s in segments]), np.array([len(s.points) for s in segments])
        normals, points = se2.rotate(pose, left_normals(points, sizes)), se2.transform(pose, points)
        found, ends = self.near(points, normals), np.cumsum(sizes)
        for segment, a, b in zip(segments, (ends - sizes).tolist(), ends.tolist(), strict=True):
            yield segment, points[a:b], found.part(a, b)

    def near(self, points: Float[np.ndarray, "m 2"], normals: Float[np.ndarray, "m 2"]) -> Explanation:
        """The splines that explain each world point, nearest first."""
        return self._samples.near(points, normals, self.config)

    def _put(self, spline: MapSpline, seen_by: set[int]) -> None:
        """Hold a spline under its id, or hold it anew."""
        t, points, normals = spline.curve.sample_with_normals(SAMPLE_SPACING, spline.span)
        self._splines[spline.id] = _Held(spline, points, normals, seen_by)
        self._samples.put(spline.id, t, points, normals)

    def _drop(self, spline: int) -> None:
        self._samples.drop(spline)
        del self._splines[spline]

    # -- moving along --------------------------------------------------------------------------------------------
    def carry(
        self, key_scans: Int[np.ndarray, "n"], before: Float[np.ndarray, "n 3"], after: Float[np.ndarray, "n 3"]
    ) -> None:
        """Let every spline go along with the key scans that saw it, as these moved from `before` to `after`."""
        moves = se2.compose(after, se2.inverse(before))
        for held in list(self._splines.values()):
            seen = np.searchsorted(key_scans, sorted(held.seen_by))
            curve = held.spline.curve
            moved = curve.with_control_points(carried(curve.control_points, before[seen, :2], moves[seen]))
            self._put(replace(held.spline, curve=moved), held.seen_by)

    def forget(self, scan: int) -> None:
        """Drop the splines that `scan` or a later one started, and that these saw the others."""
        for spline, held in list(self._splines.items()):
            if held.spline.born >= scan:
                self._drop(spline)
            else:
                held.seen_by = {seen for seen in held.seen_by if seen < scan} or {held.spline.born}

    # -- decisions ---------------------------------------------------------------------------------------------
    def _decide(self, sight: Sight) -> list[Association]:
        pieces = self._smooth_pieces(cut_into_pieces(sight.seen, self.config), sight.segment.points)
        return self.model.take_in(self, sight, pieces)

    def _smooth_pieces(self, pieces: Sequence[Piece], points: Float[np.ndarray, "m 2"]) -> list[Piece]:
        """Unexplained pieces cut at sparse places, and until the model has one smooth curve for each."""
        out: list[Piece] = []
        for piece in pieces:
            if piece.spline is not None:
                out.append(piece)
                continue
            for a, b in itertools.pairwise(sparse_cuts(points[piece.a : piece.b], self.config)):
                dense = points[piece.a + a : piece.a + b]
                cuts = [piece.a + a + k for k in smooth_cuts(dense, self.model.through, self.config.smooth)]
                out.extend(Piece(start, end, None) for start, end in itertools.pairwise(cuts))
        return out

    def association(self, sight: Sight, piece: Piece, verdict: Verdict, relation: Relation | None) -> Association:
        """The record of a decision."""
        segment = sight.segment
        candidates = candidates_of(sight.seen, piece.a, piece.b)
        chosen = next((c for c in candidates if c.spline == piece.spline), None)
        first, last = int(segment.beams[piece.a]), int(segment.beams[piece.b - 1])
        distance = chosen.distance if chosen else float("nan")
        return Association(
            sight.scan, segment.index, first, last, verdict, piece.spline, distance, self.config.gate, candidates,
            relation,
        )  # fmt: skip

    # -- growth, asked for by the model ----------------------------------------------------------------------------
    def spline(self, spline: int) -> MapSpline:
        """The spline under which this id lives now."""
        return self._splines[self.heir(spline)].spline

    def start(self, sight: Sight, piece: Piece) -> Association:
        """Start a spline from beams that none explains, or leave them out when they are too few."""
        points = sight.points[piece.a : piece.b]
        length = float(cumulated_chords(points)[-1])
        if len(points) < self.config.new_points or length < self.config.new_length:
            return self.association(sight, piece, Verdict.GATED, None)
        curve = self.model.through(points)
        inherited = self.inherited(sight.scan, sight.segment.index) if self.inherited else -1
        taken = inherited in self._splines or inherited in self.heirs
        new = self.next_id if inherited < 0 or taken else inherited
        self.next_id = max(self.next_id, new + 1)
        history = f"started by scan {sight.scan}, {length:.2f} m"
        self._put(MapSpline(new, curve, (0.0, length), sight.scan, 0, (history,)), {sight.scan})
        return self.association(sight, Piece(piece.a, piece.b, new), Verdict.NEW, Relation.FULL)

    def grow(
        self, spline: int, curve: BSpline, span: tuple[float, float], points: Float[np.ndarray, "m 2"], scan: int
    ) -> bool:
        """Give a spline a longer curve, unless it is none or these points lie too far from it."""
        held = self._splines[self.heir(spline)]
        gain = (span[1] - span[0]) - (held.spline.span[1] - held.spline.span[0])
        if gain <= 0.0 or largest_distance(curve, span, points) > self.config.smooth:
            return False
        history = (*held.spline.history, f"grew by {gain:.2f} m at scan {scan}")
        self._put(replace(held.spline, curve=curve, span=span, history=history), held.seen_by)
        return True

    def carries_on(self, spline: int, points: Float[np.ndarray, "m 2"], *, forward: bool) -> bool:
        """Whether points lie beyond the end (or start) of a spline, near it, and in its direction."""
        end, out = self._splines[self.heir(spline)].end(forward=forward)
        off = (points if forward else points[::-1]) - end
        away = np.linalg.norm(off, axis=1)
        beyond = int(np.argmax(away > self.config.along))
        if away[0] >= self.config.extension or away[beyond] <= self.config.along:
            return False
        return bool(off[beyond] @ out > np.cos(self.config.join_turn) * away[beyond])

    def _join_neighbours(self, scan: int, decided: Sequence[Association]) -> None:
        """Two splines that one segment shows to follow each other become one; the older id lives on."""
        for before, after in itertools.pairwise(decided):
            if before.segment != after.segment or before.spline is None or after.spline is None:
                continue
            a, b = self.heir(before.spline), self.heir(after.spline)
            if a != b and self._meet(self._splines[a], self._splines[b]):
                self._join(a, b, scan)

    def _meet(self, a: _Held, b: _Held) -> bool:
        """Whether b starts where a ends, in the same direction."""
        (end, out), (start, back) = a.end(forward=True), b.end(forward=False)
        near = np.linalg.norm(start - end) < self.config.join_gap
        return bool(near and -(out @ back) > np.cos(self.config.join_turn))

    def _join(self, a: int, b: int, scan: int) -> None:
        """Join b to the end of a under the lower id."""
        first, second = self._splines[a], self._splines[b]
        forward = ((second.points - first.points[-1]) * (first.points[-1] - first.points[-2])).sum(1) > 0
        points = np.concatenate([first.points, second.points[forward]])
        curve = self.model.through(points)
        if largest_distance(curve, curve.domain, points) > self.config.smooth:
            return
        keep, gone = min(a, b), max(a, b)
        older, other = (first.spline, second.spline) if first.spline.id == keep else (second.spline, first.spline)
        history = (*older.history, f"joined spline {gone} at scan {scan}")
        span = (0.0, float(cumulated_chords(points)[-1]))
        seen_by = first.seen_by | second.seen_by
        born = min(older.born, other.born)
        self._drop(gone)
        self._put(MapSpline(keep, curve, span, born, 0, history), seen_by)
        self.heirs[gone] = keep


def carried(
    points: Float[np.ndarray, "n 2"], places: Float[np.ndarray, "k 2"], moves: Float[np.ndarray, "k 3"]
) -> Float[np.ndarray, "n 2"]:
    """World points moved by the mean of `moves` (motions of the world), nearer `places` counting for more (1/d²)."""
    away = np.square(points[:, None] - places).sum(-1)
    weight = 1.0 / (away + 1e-2)
    moved = se2.transform(moves, points[:, None])
    return np.einsum("nk,nkd->nd", weight / weight.sum(1, keepdims=True), moved)
