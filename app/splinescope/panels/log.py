"""The log: what is in the file, and how to open another one."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import viser

from bspline_slam.scan import ScanLog
from splinescope import table
from splinescope.activity import duration
from splinescope.commands import OpenLog
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post
from splinescope.session import Session

WAYS: Buttons = {"By its path …": "open-log", "The sample": "open-sample"}


class LogPanel:
    """Figures and notes of the open log; path, samples and upload for the next."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._post = post
        self._shown: ScanLog | None = None
        self._uploads = tempfile.TemporaryDirectory(prefix="splinescope-")
        self._about = gui.add_html("")
        with gui.add_folder("Open another log"):
            self._ways = gui.add_html("")
            self._upload = gui.add_upload_button("Upload a file…", icon=viser.Icon.UPLOAD)
            gui.add_html(table.block(table.paragraph(FORMATS, "dim")))

        @self._upload.on_upload
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                self._open_upload()

    def refresh(self, session: Session) -> None:
        if session.log is None:
            self._about.content = table.block(table.paragraph("No log is open."))
        elif session.log is not self._shown:
            self._about.content = table.block(*about(session.log))
        self._shown = session.log
        self._ways.content = table.block(action_row(session, WAYS))

    def _open_upload(self) -> None:
        file = self._upload.value
        place = Path(tempfile.mkdtemp(dir=self._uploads.name)) / (Path(file.name).name or "upload")
        place.write_bytes(file.content)
        self._post(OpenLog(place))


FORMATS = "CARMEN text (.log, .clf, also .gz), ROS 1 .bag, ROS 2 .db3 or .mcap."


def about(log: ScanLog) -> list[str]:
    """What is in the file, as HTML parts."""
    parts = [table.pairs(figures(log))]
    if log.notes:
        parts += [table.heading("Notes on the file"), table.bullets(log.notes)]
    return parts


def figures(log: ScanLog) -> list[tuple[str, str]]:
    """Names and values of what a log holds."""
    rows = [("file", log.path.name), ("scans", f"{len(log):,}")]
    if len(log):
        scan = log[0]
        opening = np.degrees(scan.bearings[-1] - scan.bearings[0]) if len(scan.bearings) else 0.0
        rows += [
            ("time span", duration(float(log.times[-1] - log.times[0]))),
            ("beams", f"{len(scan.bearings)} over {opening:.0f}°, to {scan.range_max:.0f} m"),
        ]
    rows += [
        ("odometry", "yes" if log.odometry is not None else "none: scan matching alone"),
        ("ground truth", "yes" if log.truth is not None else "none"),
    ]
    return rows
