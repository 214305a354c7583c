"""What hand edits would change, drawn over the map: one hue of its own, and never a solid line."""

from __future__ import annotations

import numpy as np

from splinescope.palette import PURPLE, Glyph, LineStyle, Theme
from splinescope.scene.curves import sampled
from splinescope.scene.detail import Detail
from splinescope.scene.paths import simplified
from splinescope.scene.strokes import Strokes, broken, dashed, glyphs, polyline
from splinescope.view import GhostView

GLYPH_PIXELS = 3.0


def changed(view: GhostView, theme: Theme, detail: Detail) -> Strokes:
    """Splines as they would be, dashed, and the path as it would be, dotted."""
    hue, parts = theme.legible(PURPLE), []
    if view.path is not None:
        path = simplified(view.path[:, :2], 0.5 * detail.pixel)
        parts.append(Strokes.of(dashed(path, LineStyle.DOTTED, detail.pixel), hue))
    if view.splines is not None and len(view.splines):
        segments, _ = sampled([s.curve for s in view.splines], [s.span for s in view.splines], detail)
        parts.append(Strokes.of(broken(segments, LineStyle.DASHED, detail.pixel), hue))
    return Strokes.joined(parts)


def scan(view: GhostView, theme: Theme, detail: Detail) -> Strokes:
    """The beam ends of the ghost scan as small squares, and the points clicked so far as crosses."""
    hue, parts = theme.legible(PURPLE), []
    for glyph, points, size in ((Glyph.SQUARE, view.points, GLYPH_PIXELS), (Glyph.CROSS, view.marks, 8.0)):
        places = np.array([] if points is None else points, dtype=float).reshape(-1, 2)
        parts.append(glyphs(glyph, places, np.tile(hue, (len(places), 1)), size * detail.pixel))
    return Strokes.joined(parts)


def moves(view: GhostView, theme: Theme, detail: Detail) -> Strokes:
    """Where the last edits moved key poses: a line from each, longer than the move where that is small."""
    if view.moves is None:
        return Strokes.none()
    return Strokes.joined(Strokes.of(polyline(line), theme.legible(PURPLE)) for line in view.moves)
