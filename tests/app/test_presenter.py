"""What a page is shown when it comes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.inline import session_with
from app.logs import corridor_log
from splinescope.browser.page import Page, Viewport
from splinescope.guide import Guide
from splinescope.presenter import LONGEST_REST, Presenter


def test_a_page_that_said_what_it_sees_before_it_was_known_is_shown_the_map(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, _ = session_with(corridor_log(np.random.default_rng(8), 30))
    presenter = Presenter(page, session, Guide(session), lambda item: None)
    fitted: list[int] = []
    clients: dict[int, Any] = {}
    monkeypatch.setattr(page.server, "get_clients", lambda: clients)
    monkeypatch.setattr(page, "viewport_of", lambda client: Viewport(0.0, 0.0, 0.01, 1000.0, 600.0))
    monkeypatch.setattr(page, "fit", lambda bounds, client: fitted.append(client.client_id))
    monkeypatch.setattr(page, "send", lambda topic, value, client=None: None)
    presenter.page_moved()
    assert fitted == []
    clients[1] = SimpleNamespace(client_id=1)
    presenter.greet(1, None)
    assert fitted == [1]
    presenter.page_moved()
    assert fitted == [1], "once is enough: from then on it is its person's"


def test_the_picture_leaves_before_the_panels_are_brought_up_to_date(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, _ = session_with(corridor_log(np.random.default_rng(8), 30))
    presenter = Presenter(page, session, Guide(session), lambda item: None)
    sent: list[str] = []
    monkeypatch.setattr(page, "send", lambda topic, value, client=None: sent.append(topic))
    monkeypatch.setattr(page.server, "flush", lambda: sent.append("on its way"))
    session.revision += 1
    presenter.show()
    assert "timeline" in sent
    assert sent[-1] == "on its way"
    while "status" not in sent:
        assert presenter.seconds_idle < LONGEST_REST, "there is more to show"
        presenter.show()
    assert sent.index("on its way") < sent.index("refusals")
