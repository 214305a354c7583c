"""What the tests of the application share: a page of our own on a free port, and windows that look at it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Browser

from app.chromium import Window, opened
from splinescope.actions import described
from splinescope.browser.page import Page, open_page


@pytest.fixture
def page() -> Iterator[Page]:
    """An empty page of ours on a free port, with the table of actions."""
    page = open_page("127.0.0.1", 0, title="SplineScope")
    page.send("actions", described())
    yield page
    page.stop()


@pytest.fixture
def open_window(browser: Browser) -> Iterator[Callable[..., Window]]:
    """Opens windows by url; at the end none of them may have complained on its console."""
    windows = []
    with ExitStack() as stack:

        def open_one(url: str, **size: int) -> Window:
            windows.append(stack.enter_context(opened(browser, url, **size)))
            return windows[-1]

        yield open_one
    assert [error for window in windows for error in window.errors] == []
