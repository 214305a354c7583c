"""Consistency: are the errors of this map as large as its covariances say? Key scan by key scan."""

from __future__ import annotations

import viser

from bspline_slam.lab.innovations import MOST_SCANS
from bspline_slam.lab.scan_test import ScanTest
from splinescope import table
from splinescope.activity import Work
from splinescope.palette import theme
from splinescope.panels.action_row import action_row
from splinescope.panels.panel import Post
from splinescope.pictures.consistency import in_words, scan_test_picture
from splinescope.session import Session

INTRODUCTION = (
    "Each dot is a key scan: an error squared, divided by what the covariances expect. Honest covariances give 1 on "
    "average and keep 95 % of the dots in the blue band. Above it (○) the map claims to know more than it does; "
    "below it (×) it is too careful."
)
NEES = (
    "The pose of the estimate against the true one, the truth moved as a whole so that both agree at the first key "
    "scan. Poses of one drive share their errors, so a whole stretch can leave the band together."
)
NIS = (
    "How far the segments of a key scan lie from where all other scans expect them, by the noise of the laser and "
    "without robust weights. What nothing else in the log expects is left out. Of a long log "
    f"{MOST_SCANS} key scans, evenly spread, are tested."
)


class TestView:
    """One test: its picture, the share inside in words, and the way to its scans."""

    def __init__(self, gui: viser.GuiApi, title: str, name: str, explanation: str) -> None:
        self._name, self._explanation = name, explanation
        self._ways = {"Worst scan": f"{name.lower()}-worst", "Next above the band": f"{name.lower()}-next"}
        self._drawn: tuple[ScanTest, int, bool] | None = None
        self._folder = gui.add_folder(title)
        with self._folder:
            self._text = gui.add_html("")

    def refresh(self, test: ScanTest | None, session: Session) -> None:
        """Show the test; nothing of it where there is none."""
        self._folder.visible = test is not None and len(test.scans) > 1
        if test is None or len(test.scans) < 2 or self._drawn == (test, session.cursor, session.preferences.dark):
            return
        self._drawn = (test, session.cursor, session.preferences.dark)
        drawn = scan_test_picture(test, session.cursor, self._name, theme(session.preferences.dark))
        said = table.paragraph(f"{self._name}: {in_words(test)} Mean {test.normalised.mean():.2f}.")
        ways = action_row(session, self._ways)
        self._text.content = table.block(drawn, said, ways, table.paragraph(self._explanation, "dim"))


class ConsistencyPanel:
    """NEES where the log has a truth, and NIS always."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        with gui.add_folder("Consistency", expand_by_default=False):
            self._text = gui.add_html("")
            self._nees = TestView(gui, "Error against the truth (NEES)", "NEES", NEES)
            self._nis = TestView(gui, "Surprise of each scan (NIS)", "NIS", NIS)

    def refresh(self, session: Session) -> None:
        tests = session.findings.consistency
        self._text.content = table.block(*introduction(session))
        self._nees.refresh(tests.nees if tests is not None else None, session)
        self._nis.refresh(tests.nis if tests is not None else None, session)


def introduction(session: Session) -> list[str]:
    """What is to be seen, or why there is nothing, as HTML parts."""
    tests, activity = session.findings.consistency, session.activity
    if tests is not None:
        parts = [table.paragraph(INTRODUCTION, "dim")]
        if tests.nees is None:
            parts.append(table.paragraph("This log has no ground truth, so there is no NEES."))
        return parts
    if session.log is None:
        return [table.paragraph("No log is open.")]
    if activity is not None and activity.work is Work.COVARIANCES:
        return [table.paragraph("The map is being tested; the figures come when that has ended.")]
    if activity is not None:
        return [table.paragraph("The map is tested when processing or optimising has ended.")]
    return [
        table.paragraph(
            "The map has not been tested. Optimise it under Estimate, or show its result again under Compare."
        )
    ]
