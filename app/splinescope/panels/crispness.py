"""Crispness: how near beams end to the curves that they saw, over the whole map and along each curve."""

from __future__ import annotations

import numpy as np
import viser

from splinescope import table
from splinescope.activity import Work
from splinescope.commands import SetColouring
from splinescope.grades import RESIDUALS, shares
from splinescope.palette import theme
from splinescope.panels.panel import Post, on_change
from splinescope.pictures.residuals import grades_picture, residual_picture
from splinescope.quality import Quality
from splinescope.session import Session
from splinescope.typeset import typeset
from splinescope.view import Colouring

TITLE = "Crispness"
MEANING = (
    "A crisp map has its beams close to its curves. Half a centimetre to a centimetre is the laser's own noise; more "
    "tells of people, of clutter, or of a wall drawn at two places."
)


class CrispnessPanel:
    """Two figures, their histogram, and the colours of the curves."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._drawn: tuple[Quality | None, bool, str] | None = None
        self._folder = gui.add_folder(TITLE)
        with self._folder:
            self._text = gui.add_html("")
            self._colour = gui.add_checkbox("Colour the curves by it", initial_value=False)
        on_change(self._colour, lambda: post(SetColouring(chosen(self._colour.value))))

    def refresh(self, session: Session) -> None:
        self._colour.value = session.preferences.colouring is Colouring.RESIDUAL
        quality, dark = session.findings.quality, session.preferences.dark
        state = (quality, dark, absence(session))
        if self._drawn == state:
            return
        self._drawn = state
        self._folder.label = TITLE if quality is None else typeset(f"{TITLE}: {millimetres(quality.crispness.rms)}")
        self._text.content = table.block(*crispness(quality, dark) if quality else [table.paragraph(absence(session))])


def chosen(on: bool) -> Colouring:
    """Curves coloured by their residuals, or each by its own colour."""
    return Colouring.RESIDUAL if on else Colouring.SPLINE


def absence(session: Session) -> str:
    """Why nothing is measured yet."""
    activity = session.activity
    if session.log is None:
        return "No log is open."
    if activity is not None and activity.work is Work.COVARIANCES:
        return "The map is being measured."
    if activity is not None:
        return "The map is measured when processing or optimising has ended."
    return "The map has not been measured. Optimise it under Estimate, or show its result again under Compare."


def crispness(quality: Quality, dark: bool) -> list[str]:
    """The figures and the histogram as HTML parts."""
    found = quality.crispness
    if not np.isfinite(found.rms):
        return [table.paragraph("No beam of a key scan ends on a curve of this map.")]
    rows = [
        ("beam ends on walls, in key scans", f"{found.beams:,}"),
        ("of these within 3 cm of a curve", f"{found.within_3cm:.1%}"),
        ("RMS distance of those within 5 cm", millimetres(found.rms)),
    ]
    colours = theme(dark)
    return [
        table.pairs(rows),
        residual_picture(quality.histogram, colours),
        table.paragraph(MEANING, "dim"),
        table.heading("RMS along the curves, and the share of them"),
        grades_picture(shares(quality.stretches, RESIDUALS), colours),
    ]


def millimetres(metres: float) -> str:
    return f"{1000 * metres:.1f} mm" if np.isfinite(metres) else "–"
