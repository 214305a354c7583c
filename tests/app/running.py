"""The whole application as a person has it: its page, its processes, and a log that it processes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from app.chromium import PATIENCE, until
from splinescope.browser.page import open_page
from splinescope.commands import OpenLog
from splinescope.viewer import Viewer

COMPILING = 600.0
"""How long (s) to wait for what compiles the kernels first, on the slowest machine that tests run on."""


def settled(viewer: Viewer, condition: Callable[[], bool], what: str, seconds: float = PATIENCE) -> None:
    """Wait until `condition` holds, also after the owner of the session is through with what it was doing: seen from
    another thread, half of a change would do."""

    def seen() -> bool:
        return condition() and viewer.caught_up(PATIENCE) and condition()

    until(seen, what, seconds)


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
