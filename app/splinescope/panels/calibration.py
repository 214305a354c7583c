"""The calibration: what the finished map says of the wheels and of the laser, each figure with a sentence."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.calibration_text import laser_findings, odometry_findings
from splinescope.panels.panel import Post
from splinescope.session import Session

TITLE = "Calibration"
UNMEASURED = "It is measured when processing or optimising has ended."


class CalibrationPanel:
    """Odometry's bias and lag, the range noise and the fit."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        with gui.add_folder(TITLE, expand_by_default=False):
            self._text = gui.add_html("")

    def refresh(self, session: Session) -> None:
        self._text.content = table.block(*calibration(session))


def calibration(session: Session) -> list[str]:
    """All findings as HTML parts, or why there are none."""
    quality, log = session.findings.quality, session.log
    if quality is None or log is None:
        return [table.paragraph(UNMEASURED, "dim")]
    laser = laser_findings(quality.laser, quality.chi2_per_dof, quality.calibration)
    unfit = sorted(step.scan for step in session.findings.steps.values() if step.unfit)
    wheels = odometry_findings(quality.odometry, log.odometry is not None, unfit, quality.untold)
    return [
        table.heading("The laser, as the residuals tell it"),
        table.explained(laser),
        table.heading("The wheels, as the estimate tells them"),
        table.explained(wheels),
    ]
