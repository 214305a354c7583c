"""Line work as values: coloured line segments, made of polylines, dashes and glyphs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8

from splinescope.palette import Colour, Glyph, LineStyle


@dataclass(frozen=True, eq=False, slots=True)
class Strokes:
    """Line segments in the plane (m), each with its colour."""

    segments: Float[np.ndarray, "n 2 2"]
    colours: UInt8[np.ndarray, "n 3"]

    def __len__(self) -> int:
        return len(self.segments)

    @classmethod
    def none(cls) -> Strokes:
        """Nothing drawn."""
        return cls(np.zeros((0, 2, 2)), np.zeros((0, 3), dtype=np.uint8))

    @classmethod
    def of(cls, segments: Float[np.ndarray, "n 2 2"], colour: Colour) -> Strokes:
        """Segments of one colour."""
        return cls(segments, np.tile(colour, (len(segments), 1)))

    @classmethod
    def joined(cls, parts: Iterable[Strokes]) -> Strokes:
        """Everything in one."""
        parts = [part for part in parts if len(part)]
        if not parts:
            return cls.none()
        return cls(np.concatenate([part.segments for part in parts]), np.concatenate([part.colours for part in parts]))


def polyline(points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "m 2 2"]:
    """The n − 1 segments between neighbouring points; those with a NaN are left out."""
    segments = np.stack([points[:-1], points[1:]], axis=1)
    return segments[np.isfinite(segments).all(axis=(1, 2))]


def dashed(points: Float[np.ndarray, "n 2"], style: LineStyle, pixel: float) -> Float[np.ndarray, "m 2 2"]:
    """A polyline broken into the dashes of `style`, at `pixel` metres per pixel."""
    return broken(polyline(points), style, pixel)


def broken(segments: Float[np.ndarray, "n 2 2"], style: LineStyle, pixel: float) -> Float[np.ndarray, "m 2 2"]:
    """Segments, one after another, broken into the dashes of `style`, at `pixel` metres per pixel."""
    pattern = np.array(style.pattern) * pixel
    if not len(pattern) or not len(segments):
        return segments
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1))])
    edges = np.concatenate([[0.0], np.cumsum(pattern)])
    periods = np.arange(int(along[-1] / edges[-1]) + 1) * edges[-1]
    cuts = (periods[:, None] + edges[:-1]).ravel()
    stops = np.union1d(along, cuts[cuts < along[-1]])
    middle = 0.5 * (stops[:-1] + stops[1:])
    ink = np.searchsorted(edges, middle % edges[-1], side="right") % 2 == 1
    segment = np.clip(np.searchsorted(along, middle[ink], side="right") - 1, 0, len(segments) - 1)
    ends = np.stack([stops[:-1][ink], stops[1:][ink]], axis=1)
    share = (ends - along[segment, None]) / np.diff(along)[segment, None]
    start, reach = segments[segment, 0], segments[segment, 1] - segments[segment, 0]
    return start[:, None] + share[:, :, None] * reach[:, None]


def _ring(count: int) -> list[tuple[float, float]]:
    angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
    return list(zip(np.cos(angle).tolist(), np.sin(angle).tolist(), strict=True))


_SHAPES: dict[Glyph, Sequence[Sequence[tuple[float, float]]]] = {
    Glyph.CIRCLE: [_ring(10)],
    Glyph.CHEVRONS: [[(-0.9, -0.9), (0.0, 0.0), (-0.9, 0.9)], [(0.1, -0.9), (1.0, 0.0), (0.1, 0.9)]],
    Glyph.PLUS: [[(-1.0, 0.0), (1.0, 0.0)], [(0.0, -1.0), (0.0, 1.0)]],
    Glyph.CROSS: [[(-0.85, -0.85), (0.85, 0.85)], [(-0.85, 0.85), (0.85, -0.85)]],
    Glyph.BAR: [[(-1.0, 0.0), (1.0, 0.0)]],
    Glyph.DIAMOND: [[(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0)]],
    Glyph.SQUARE: [[(-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8), (-0.8, -0.8)]],
    Glyph.CORNER: [[(-0.9, 0.9), (-0.9, -0.9), (0.9, -0.9)]],
    Glyph.OPEN: [[(0.7, 0.9), (-0.7, 0.0), (0.7, -0.9)]],
    Glyph.FAN: [[(-0.9, 0.8), (0.0, -0.8), (0.9, 0.8)]],
    Glyph.WARNING: [
        [(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8), (0.0, 1.2)],
        [(0.0, 0.6), (0.0, -0.1)],
        [(0.0, -0.35), (0.0, -0.55)],
    ],
    Glyph.PIN: [[(0.0, -1.0), (0.0, 0.1)], [(-0.8, 0.1), (0.8, 0.1), (0.5, 1.0), (-0.5, 1.0), (-0.8, 0.1)]],
}
_UNIT = {glyph: np.concatenate([polyline(np.array(line)) for line in lines]) for glyph, lines in _SHAPES.items()}


def glyph_shape(glyph: Glyph) -> Float[np.ndarray, "s 2 2"]:
    """The segments of a glyph, within about one unit around the origin, y upwards."""
    return _UNIT[glyph]


def glyphs(
    glyph: Glyph, centres: Float[np.ndarray, "n 2"], colours: UInt8[np.ndarray, "n 3"], radius: float
) -> Strokes:
    """The same glyph at every centre, of this radius (m)."""
    shape = _UNIT[glyph] * radius
    segments = (centres[:, None, None, :] + shape).reshape(-1, 2, 2)
    return Strokes(segments, np.repeat(colours, len(shape), axis=0))
