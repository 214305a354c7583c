"""The reception: greets pages that come, and knows which of them drives what all see."""

from __future__ import annotations

import logging
from dataclasses import replace

from splinescope import commands as ask
from splinescope.actions import Perform, find
from splinescope.browser.link import Link
from splinescope.browser.visitors import Visitors
from splinescope.notice import Notice
from splinescope.posted import Goodbye, Hello, PageMoved, Posted
from splinescope.presenter import Presenter
from splinescope.session import Session

logger = logging.getLogger(__name__)

OVERTAKEN = Notice("Somebody else drives now", "You are watching. Press A to take control back.")
WATCHING = Notice("You are watching", "Another page drives what all see. Press A to take control.")
LINK_WAITS = Notice("You are watching", "The link shows its place. Press A to take control and to open its moment.")


class Reception:
    """State: who has come, who drives, and the links that those who watch have come by."""

    def __init__(self, session: Session, presenter: Presenter) -> None:
        self._session, self._presenter = session, presenter
        self._visitors = Visitors()
        self._arriving: dict[int, Hello] = {}
        self._links: dict[int, Link] = {}

    def admits(self, item: Posted, client: int) -> bool:
        """Whether this page may do this; one that may not is told why."""
        allowed = self._may(item, client)
        if not allowed and not isinstance(item, ask.ShowTab):
            self._session.tell(replace(WATCHING, client=client))
        return allowed

    def _may(self, item: Posted, client: int) -> bool:
        """Its own view is a page's own affair, all else is the driver's. Where nobody drives, who acts first does."""
        if isinstance(item, (Hello, Goodbye, PageMoved)):
            return True
        if isinstance(item, Perform) and (action := find(item.action)) and action.own:
            return True
        if self._visitors.driver is None:
            self._visit(self._visitors.driven_by(client))
        return self._visitors.driver == client

    def is_driven_by(self, client: int) -> bool:
        """Whether this page drives, and has been greeted."""
        return client == self._visitors.driver and client not in self._arriving

    def receive(self, client: int, hello: Hello) -> None:
        """The viewer may know a page a little later than it says hello: it is greeted then."""
        self._visitors = self._visitors.came(client, hello.name)
        self._arriving[client] = hello
        self.greet_known()

    def greet_known(self) -> None:
        """Greet those who can be spoken to by now."""
        for client in [client for client in self._arriving if self._presenter.knows(client)]:
            self._greet(client, self._arriving.pop(client))

    def left(self, client: int) -> None:
        """This page is gone."""
        self._arriving.pop(client, None)
        self._links.pop(client, None)
        self._visit(self._visitors.left(client))

    def drive(self, client: int) -> None:
        """From now on this page drives; it opens the moment of the link that it came by."""
        before = self._visitors.driver
        self._visit(self._visitors.driven_by(client))
        if before not in (None, client):
            self._session.tell(replace(OVERTAKEN, client=before))
        link = self._links.pop(client, None)
        if link is not None:
            self._session.apply(ask.FollowLink(link))

    def _greet(self, client: int, hello: Hello) -> None:
        self._presenter.show_roles(self._visitors)
        link = Link.parse(hello.query)
        if not link.empty:
            if self._visitors.driver == client:
                self._session.apply(ask.FollowLink(link))
            else:
                self._links[client] = link
                self._session.tell(replace(LINK_WAITS, client=client))
        place = link.place or hello.place
        if hello.back:
            self._presenter.greet_again(client, place)
        else:
            self._presenter.greet(client, place)

    def _visit(self, visitors: Visitors) -> None:
        self._visitors = visitors
        self._presenter.show_roles(visitors)
