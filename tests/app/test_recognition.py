"""A log that is opened is held against that of the last visit."""

from __future__ import annotations

from pathlib import Path

from app.desk import LOG, Idle
from bspline_slam.logs import open_log
from splinescope import commands as ask
from splinescope.browser.preferences import Preferences
from splinescope.session import Session


def test_a_session_says_when_its_log_moved_or_changed(tmp_path: Path) -> None:
    log = open_log(LOG)
    here = str(LOG.absolute())
    for known, title in (
        (Preferences(log="/old/place.log", log_hash=log.content_hash), "The log has moved"),
        (Preferences(log=here, log_hash="another"), "The log has changed"),
        (Preferences(log=here, log_hash=log.content_hash), None),
        (Preferences(), None),
    ):
        session, request = Session(Idle(), lambda _: None, known), ask.OpenLog(LOG)
        session.apply(request)
        session.apply(ask.LogOpened(request, log))
        assert [notice.title for notice in session.notices] == ([title] if title else [])
        assert (session.preferences.log, session.preferences.log_hash) == (here, log.content_hash)
