"""The whole application as a person has it: its page, its processes, and a log that it processes."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from splinescope.browser.page import open_page
from splinescope.commands import OpenLog
from splinescope.viewer import Viewer


@contextmanager
def running_viewer(log: Path, memory: Path) -> Iterator[Viewer]:
    """The application on a free port with the log being processed; it remembers things in `memory`."""
    viewer = Viewer(open_page("127.0.0.1", 0), memory)
    thread = threading.Thread(target=viewer.run)
    thread.start()
    viewer.post(OpenLog(log))
    try:
        yield viewer
    finally:
        viewer.stop()
        thread.join(10)
        viewer.close()
