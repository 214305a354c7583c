"""Whether a log that is opened is the one that a session refers to."""

from __future__ import annotations

from bspline_slam.scan import ScanLog
from splinescope.browser.preferences import Preferences
from splinescope.notice import Notice


def recognition(log: ScanLog, before: Preferences) -> tuple[Notice, ...]:
    """What to say where the log of the last visit has changed or moved."""
    path, found = str(log.path.absolute()), []
    if before.log == path and before.log_hash not in ("", log.content_hash):
        sentence = f"{log.name} is not what it was: edits and views of before stay away."
        found.append(Notice("The log has changed", sentence))
    if before.log not in ("", path) and before.log_hash == log.content_hash:
        found.append(Notice("The log has moved", f"It was {before.log} before."))
    return tuple(found)
