"""The decisions: which segment of the current scan was given to which spline, and how clearly."""

from __future__ import annotations

import numpy as np
import viser

from bspline_slam.association import Association
from splinescope import table
from splinescope.palette import VERDICT_STYLES, Glyph
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post
from splinescope.session import Session
from splinescope.view import ScanView

ROW = "segment"
"""Name of a row in what the page tells of clicks."""
WAYS: dict[str, Buttons] = {
    "Segment": {
        "Next": "next-segment",
        "Before": "previous-segment",
        "All": "all-pieces",
        "Its spline": "spline-of-segment",
    },
    "Key scan": {"Next": "next-key", "Before": "previous-key"},
}
HEADERS = ("Seg", "Beams", "Spline", "Verdict", "RMS / gate", "Runner-up")
GLYPHS = {Glyph.CIRCLE: "○", Glyph.CHEVRONS: "»", Glyph.PLUS: "+", Glyph.CROSS: "✕", Glyph.BAR: "–"}


class DecisionsPanel:
    """A table of the associations; a click on a row selects its segment."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._text = gui.add_html("")

    def refresh(self, session: Session) -> None:
        chosen = session.selection
        segment = chosen.id if chosen is not None and chosen.kind == "segment" else None
        rows = (action_row(session, buttons, label=label) for label, buttons in WAYS.items())
        self._text.content = table.block(*rows, *decisions(session.scan_view, segment))


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
    return [
        table.paragraph(f"Key scan {scan.scan.index}: {len(scan.associations)} decisions; distances in mm."),
        table.leading(ROW, HEADERS, [(a.segment, row(a), "") for a in scan.associations], selected=segment),
    ]


def row(association: Association) -> tuple[str, ...]:
    """One decision as the texts of its columns."""
    second = association.runner_up
    return (
        f"{GLYPHS[VERDICT_STYLES[association.verdict].glyph]} {association.segment}",
        f"{association.first}–{association.last}",
        "–" if association.spline is None else str(association.spline),
        association.verdict.value + (" by hand" if association.by == "hand" else ""),
        f"{number(association.distance)} / {number(association.gate)}",
        "–" if second is None else f"{second.spline}: {number(second.distance)}",
    )


def number(metres: float) -> str:
    return f"{1000 * metres:.0f}" if np.isfinite(metres) else "–"
