"""Which log is opened first: the one that is asked for, else that of the session, else the sample."""

from __future__ import annotations

from pathlib import Path

from bspline_slam.errors import ConfigError
from splinescope.browser import preferences as prefs
from splinescope.paths import SAMPLE, find_log


def first_log(given: str | None, session: Path | None) -> Path:
    """The log to open with a session's file. Raises ConfigError where that file is something else than a session, which
    would be written over, or refers to a log that is gone; SplineSlamError where there is no log that is called so."""
    if session is not None:
        prefs.check(session)
    return find_log(given or (_log_of(session) if session is not None else None) or SAMPLE)


def _log_of(session: Path) -> str | None:
    """The path of the log that a session refers to."""
    log = prefs.load(session).log
    if log and not Path(log).exists():
        raise ConfigError(f"the session {session} is about {log}, which is gone: say where the log is now")
    return log or None
