"""What hand edits would change, drawn over the map: one hue of its own, and never a solid line."""

from __future__ import annotations

import numpy as np

from splinescope.palette import PURPLE, Glyph, LineStyle, Theme
from splinescope.scene.curves import sampled
from splinescope.scene.detail import Detail
from splinescope.scene.paths import simplified
from splinescope.scene.strokes import Strokes, broken, dashed, glyphs
from splinescope.view import GhostView

GLYPH_PIXELS, PIN_PIXELS = 3.0, 8.0
CELL_PIXELS, LEAST_PIXELS = 6.0, 1.5
"""Of the moves, one is drawn for each cell of the picture of so many pixels, if it is at least so long."""


def changed(view: GhostView, theme: Theme, detail: Detail) -> Strokes:
    """Splines as they would be, dashed, and the path as it would be, dotted."""
    hue, parts = theme.legible(PURPLE), []
    if view.path is not None:
        path = simplified(view.path[:, :2], detail.pixel)
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
    """Where the last edits moved key poses: a line from each, longer than the move where that is small; of many that
    begin in one place the longest, and none that would be a dot."""
    if view.moves is None or not len(view.moves):
        return Strokes.none()
    length = np.linalg.norm(view.moves[:, 1] - view.moves[:, 0], axis=1)
    order = np.argsort(-length, kind="stable")
    _, first = np.unique(np.floor(view.moves[order, 0] / (CELL_PIXELS * detail.pixel)), axis=0, return_index=True)
    longest = np.sort(order[first])
    seen = longest[length[longest] > LEAST_PIXELS * detail.pixel]
    return Strokes.of(view.moves[seen], theme.legible(PURPLE))


def by_hand(view: GhostView, theme: Theme, detail: Detail) -> Strokes:
    """A pin stuck into each place that is held by hand; for each loop closure a line between two diamonds."""
    hue, radius = theme.legible(PURPLE), PIN_PIXELS * detail.pixel
    pins, ties = np.array(view.pins, dtype=float).reshape(-1, 2), np.array(view.ties, dtype=float).reshape(-1, 2, 2)
    ends = ties.reshape(-1, 2)
    return Strokes.joined(
        [
            glyphs(Glyph.PIN, pins + np.array([0.0, radius]), np.tile(hue, (len(pins), 1)), radius),
            glyphs(Glyph.DIAMOND, ends, np.tile(hue, (len(ends), 1)), 0.75 * radius),
            Strokes.of(ties, hue),
        ]
    )
