"""The decisions: which segment of the current scan was given to which spline, and how clearly."""

from __future__ import annotations

import numpy as np
import viser

from bspline_slam.association import Association
from splinescope import table
from splinescope.commands import Select, ShowObservation
from splinescope.palette import VERDICT_STYLES, Glyph
from splinescope.panels.panel import Post, on_press
from splinescope.session import Session
from splinescope.view import ScanView, Selection

HEADERS = ("", "Seg", "Beams", "Spline", "Verdict", "RMS / gate", "Runner-up")
GLYPHS = {Glyph.CIRCLE: "○", Glyph.CHEVRONS: "»", Glyph.PLUS: "+", Glyph.CROSS: "✕", Glyph.BAR: "–"}


class DecisionsPanel:
    """A table of the associations; a segment can be selected by its number."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._text = gui.add_html("")
        self._segment = gui.add_number("Segment", 0, min=0, step=1)
        button = gui.add_button("Select the segment")
        on_press(button, lambda: post(Select(Selection("segment", int(self._segment.value)))))
        steps = gui.add_button("Step through an observation", hint="Key s", color="gray")
        on_press(steps, lambda: post(ShowObservation(True)))

    def refresh(self, session: Session) -> None:
        chosen = session.selection
        segment = chosen.id if chosen is not None and chosen.kind == "segment" else None
        self._text.content = table.block(*decisions(session.scan_view, segment))


def decisions(scan: ScanView | None, segment: int | None) -> list[str]:
    """The table as HTML parts, with the rows of `segment` marked; a sentence where there is nothing to list."""
    if scan is None:
        return [table.paragraph("No scan is shown.")]
    if not scan.key:
        return [
            table.paragraph(f"Scan {scan.scan.index} is not a key scan, so it is not in the graph."),
            table.paragraph("Step to a key scan to see its decisions; they are marked on the timeline.", "dim"),
        ]
    if not scan.associations:
        return [table.paragraph(f"Key scan {scan.scan.index} has no segment that could be associated.")]
    marked = [number for number, a in enumerate(scan.associations) if a.segment == segment]
    return [
        table.paragraph(f"Key scan {scan.scan.index}: {len(scan.associations)} decisions; distances in mm."),
        table.table(HEADERS, map(row, scan.associations), numbers=(1, 2, 3, 5, 6), marked=marked),
    ]


def row(association: Association) -> tuple[str, ...]:
    """One decision as the texts of its columns."""
    second = association.runner_up
    return (
        GLYPHS[VERDICT_STYLES[association.verdict].glyph],
        str(association.segment),
        f"{association.first}–{association.last}",
        "–" if association.spline is None else str(association.spline),
        association.verdict.value + (" by hand" if association.by == "hand" else ""),
        f"{number(association.distance)} / {number(association.gate)}",
        "–" if second is None else f"{second.spline}: {number(second.distance)}",
    )


def number(metres: float) -> str:
    return f"{1000 * metres:.0f}" if np.isfinite(metres) else "–"
