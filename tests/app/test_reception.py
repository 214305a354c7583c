"""Who may do what among several pages, and what becomes of the links that they come by."""

from __future__ import annotations

import numpy as np
import pytest

from app.inline import session_with
from app.logs import corridor_log
from splinescope import commands as ask
from splinescope.actions import Perform
from splinescope.browser.values import Place
from splinescope.browser.visitors import Visitors
from splinescope.posted import Hello, PageMoved
from splinescope.reception import Reception
from splinescope.session import Session


class Speaking:
    """A presenter that knows whom the test says, and keeps what it was told."""

    def __init__(self) -> None:
        self.known: set[int] = set()
        self.roles = Visitors()
        self.greeted: dict[int, Place | None] = {}

    def knows(self, client: int) -> bool:
        return client in self.known

    def show_roles(self, visitors: Visitors) -> None:
        self.roles = visitors

    def greet(self, client: int, place: Place | None) -> None:
        self.greeted[client] = place


@pytest.fixture
def session() -> Session:
    session, _ = session_with(corridor_log(np.random.default_rng(8), 30))
    return session


def test_the_first_page_drives_and_others_are_told_that_they_watch(session: Session) -> None:
    presenter = Speaking()
    reception = Reception(session, presenter)  # type: ignore[arg-type]
    reception.receive(1, Hello("one", ""))
    assert presenter.greeted == {}, "it cannot be spoken to yet"
    presenter.known = {1, 2}
    reception.greet_known()
    reception.receive(2, Hello("two", ""))
    assert presenter.greeted == {1: None, 2: None}
    assert reception.is_driven_by(1) and not reception.is_driven_by(2)
    assert reception.admits(ask.Step(1), 1)
    assert not reception.admits(ask.Step(1), 2)
    assert (session.notices[-1].title, session.notices[-1].client) == ("You are watching", 2)
    assert all(reception.admits(item, 2) for item in (PageMoved(), Perform("zoom-in")))
    reception.left(1)
    assert reception.admits(ask.Step(1), 2)


def test_a_link_shows_its_place_at_once_and_its_moment_to_who_drives(session: Session) -> None:
    presenter = Speaking()
    presenter.known = {1, 2}
    reception = Reception(session, presenter)  # type: ignore[arg-type]
    reception.receive(1, Hello("one", "scan=4"))
    assert session.cursor == 4
    reception.receive(2, Hello("two", "scan=9&camera=1,2,0.01"))
    assert presenter.greeted[2] == (1.0, 2.0, 0.01)
    assert session.cursor == 4
    assert session.notices[-1].client == 2 and "link" in session.notices[-1].text
    reception.drive(2)
    assert session.cursor == 9
    assert (session.notices[-1].title, session.notices[-1].client) == ("Somebody else drives now", 1)
    reception.drive(1)
    session.apply(ask.Seek(7))
    reception.drive(2)
    assert session.cursor == 7, "a link is followed once"
