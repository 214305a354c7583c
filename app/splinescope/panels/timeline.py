"""Time: jump to a moment of the log, and follow the processing."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.commands import FollowProcessing
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post, on_change
from splinescope.session import Session

WAYS: Buttons = {
    "Go to a scan": "go-to-scan",
    "To a second": "go-to-second",
    "First": "first-scan",
    "Last": "last-scan",
}


class TimelinePanel:
    """What the bar under the map does not offer."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._follow = gui.add_checkbox("Show the newest processed scan", initial_value=True)
        on_change(self._follow, lambda: post(FollowProcessing(self._follow.value)))
        self._text = gui.add_html("")

    def refresh(self, session: Session) -> None:
        self._follow.value = session.following
        self._text.content = table.block(action_row(session, WAYS), table.pairs(figures(session)))


def figures(session: Session) -> list[tuple[str, str]]:
    """When and where the scan under the cursor was taken."""
    scan = session.scan_view
    if scan is None or session.log is None:
        return []
    seconds = float(session.log.times[scan.scan.index] - session.log.times[0])
    hits, beams = int(scan.scan.valid.sum()), len(scan.scan.ranges)
    x, y, _ = scan.pose
    return [
        ("scan", f"{scan.scan.index:,} / {len(session.log) - 1:,}"),
        ("second of the log", f"{seconds:.2f}"),
        ("stamp in the file", f"{scan.scan.stamp:.3f}"),
        ("robot at", f"{x:.2f}, {y:.2f} m"),
        ("beams that hit", f"{hits} of {beams}"),
        ("segments", str(len(scan.segments))),
        ("role", role(session, scan.scan.index, scan.key, scan.lost)),
    ]


def role(session: Session, index: int, key: bool, lost: bool) -> str:
    """What the scan is to the estimator."""
    if index not in session.findings.steps:
        return "not processed: placed by odometry"
    if lost:
        return "lost: odometry was trusted"
    return "key scan" if key else "not a key scan: not in the graph"
