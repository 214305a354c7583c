"""What the tests of the application share: a page of our own on a free port and windows that look at it, runs over
logs, and a desk to edit at."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from app.chromium import Opener, Window, opened
from app.desk import FILE, Desk
from app.inline import InlineEstimator, deliver, session_with, stand_in
from app.logs import MemoryLog, corridor_log
from bspline_slam.slam import SlamConfig
from splinescope.actions import described
from splinescope.browser.page import Page, open_page
from splinescope.computing.jobs import Jobs
from splinescope.computing.messages import Finished, Message, ProcessLog
from splinescope.session import Session


@pytest.fixture
def page() -> Iterator[Page]:
    """An empty page of ours on a free port, with the table of actions."""
    page = open_page("127.0.0.1", 0, title="SplineScope")
    page.send("actions", described())
    yield page
    page.stop()


@pytest.fixture
def open_window(browser: Browser) -> Iterator[Opener]:
    """Opens windows by url; at the end none of them may have complained on its console."""
    windows = []
    with ExitStack() as stack:

        def open_one(url: str, **size: int) -> Window:
            windows.append(stack.enter_context(opened(browser, url, **size)))
            return windows[-1]

        yield open_one
    assert [error for window in windows for error in window.errors] == []


@pytest.fixture(scope="session")
def drive() -> MemoryLog:
    """A drive through a corridor."""
    return corridor_log(np.random.default_rng(2))


@pytest.fixture
def log(drive: MemoryLog, monkeypatch: pytest.MonkeyPatch) -> MemoryLog:
    """That drive, wherever jobs look for a log, and a stand-in that estimates."""
    stand_in(monkeypatch, drive)
    return drive


@pytest.fixture
def finished(log: MemoryLog) -> tuple[Session, InlineEstimator]:
    """A session in which the stand-in has processed that drive."""
    session, inline = session_with(log)
    deliver(session, inline)
    return session, inline


@pytest.fixture(scope="session")
def sample_run() -> list[Message]:
    """What the estimator says of the sample log."""
    sent: list[Message] = []
    Jobs(sent.append).do(ProcessLog(1, FILE, SlamConfig()), lambda: False)
    assert isinstance(sent[-1], Finished)
    return sent


@pytest.fixture
def desk(tmp_path: Path, sample_run: list[Message]) -> Desk:
    return Desk(tmp_path, sample_run)
