"""Shows a session in a page: scene, timeline, panels, camera and notices, each only when and as often as needed."""

from __future__ import annotations

import time
from dataclasses import asdict, replace

import numpy as np

from bspline_slam import se2
from splinescope.actions import described, refusals
from splinescope.browser.camera import Camera, bounds
from splinescope.browser.page import Bounds, Mark, Page, TimelineState
from splinescope.browser.values import Place
from splinescope.browser.visitors import Visitors
from splinescope.guide import Guide
from splinescope.marks import marks
from splinescope.panels.panel import Post
from splinescope.panels.side_bar import SideBar
from splinescope.panels.status import status_line
from splinescope.scene import Scene
from splinescope.session import Session
from splinescope.stage import stage_of
from splinescope.typeset import typeset
from splinescope.view import MapView

DRAWS_PER_SECOND = 30.0
PANELS_PER_SECOND = 8.0
MARKS_PER_SECOND = 1.0
LONGEST_REST = 0.25
AFTER_DRAWING = 0.03
"""Panels and marks wait so long (s) after the beginning of a drawing, so that the picture leaves first."""


class Presenter:
    """Owns the widgets and the drawing of one page; called by the owner of the session alone."""

    def __init__(self, page: Page, session: Session, guide: Guide, post: Post) -> None:
        self._page = page
        self._session = session
        self._guide = guide
        self._scene = Scene(page)
        self._camera = Camera(page)
        self._side_bar = SideBar(page.server.gui, post)
        self._turned = 0.0
        self._said: dict[str, object] = {}
        page.send("actions", described())
        self._drawn = self._refreshed = -1
        self._draw_time = self._panel_time = self._mark_time = 0.0
        self._was_busy = False
        self._seen_map: MapView | None = None
        self._marks: tuple[Mark, ...] = ()
        self._marks_of: tuple[object, ...] = ()

    @property
    def seconds_idle(self) -> float:
        """How long there is nothing to show, if nothing comes."""
        due = [time.monotonic() + LONGEST_REST]
        if self._session.playback.playing or self._session.revision != self._drawn:
            due.append(self._draw_time + 1.0 / DRAWS_PER_SECOND)
        if self._session.revision != self._refreshed:
            due.append(self._panels_due)
        if self._marks_of != self._to_be_marked:
            due.append(self._marks_due)
        return max(min(due) - time.monotonic(), 0.001)

    @property
    def _panels_due(self) -> float:
        return max(self._panel_time + 1.0 / PANELS_PER_SECOND, self._draw_time + AFTER_DRAWING)

    @property
    def _marks_due(self) -> float:
        return max(self._mark_time + 1.0 / MARKS_PER_SECOND, self._draw_time + AFTER_DRAWING)

    @property
    def _to_be_marked(self) -> tuple[object, ...]:
        findings = self._session.findings
        return findings, len(findings.steps), findings.snapshot

    def show(self) -> None:
        """Show what has changed, if its time has come."""
        session, now = self._session, time.monotonic()
        self._notify()
        if session.revision != self._drawn and now - self._draw_time >= 1.0 / DRAWS_PER_SECOND:
            self._draw_time, self._drawn = now, session.revision
            self._draw()
        elif session.revision != self._refreshed and now >= self._panels_due:
            self._panel_time, self._refreshed = now, session.revision
            self._refresh()
        elif self._marks_of != self._to_be_marked and now >= self._marks_due:
            self._marks_of, self._mark_time = self._to_be_marked, now
            self._marks = marks(session.findings)
            self._page.timeline(self._timeline())

    def _draw(self) -> None:
        """The picture and the place on the timeline, on their way before anything else is done."""
        self._scene.draw(self._session.view)
        self._page.timeline(self._timeline())
        self._look()
        self._page.server.flush()

    def _refresh(self) -> None:
        """The panels, the buttons and what is said."""
        session = self._session
        with self._page.server.atomic():
            self._side_bar.refresh(session)
        self._say("refusals", refusals(session))
        self._say("tour", self._guide.card)
        stage = stage_of(session)
        self._say("stage", None if stage is None else asdict(stage))
        activity = session.activity
        fraction = activity.fraction if activity is not None else None
        said = typeset(status_line(session))
        self._say("status", {"text": said, "busy": activity is not None, "fraction": fraction})

    def page_moved(self) -> None:
        """Some page sees another part of the world, or a new one has come."""
        self._camera.welcome(self._bounds())
        if self._scene.stale:
            self._drawn = -1

    def fit(self, client: int | None = None) -> None:
        """Show the whole map in one page, or in every page."""
        self._camera.fit(self._bounds(), client)

    def fit_scan(self, client: int | None) -> None:
        """Show the current scan in one page, or in every page."""
        if self._session.scan_view is not None:
            self._camera.fit(bounds(None, self._session.scan_view), client)

    def lead(self, client: int | None) -> None:
        """Let one page, or every page, look at what it is led to, if there is something."""
        wanted, self._session.look_wanted = self._session.look_wanted, None
        if wanted is not None:
            self._camera.lead(wanted, client)

    def knows(self, client: int) -> bool:
        """Whether a page can be spoken to."""
        return client in self._page.server.get_clients()

    def greet(self, client: int, place: Place | None) -> None:
        """Let a page that has come look at this place, or else where the log was looked at, and open its tab."""
        self.greet_again(client, place or self._session.place)
        self._tell(client, "tab", self._session.tab)

    def greet_again(self, client: int, place: Place | None) -> None:
        """Let a page that has come back after its connection was lost look at its own place, or else at all; its tab is
        open still."""
        if place is not None:
            self._camera.look(place, client)
        self._camera.welcome(self._bounds())  # it may have said what it sees before it could be spoken to

    def copy_link(self, client: int) -> None:
        """Give a page the link to this moment as it sees it."""
        handle = self._page.server.get_clients().get(client)
        viewport = self._page.viewport_of(handle) if handle is not None else None
        link = replace(self._session.link, place=None if viewport is None else viewport.place)
        if handle is not None:
            self._page.offer_link(link.query, handle)

    def show_roles(self, visitors: Visitors) -> None:
        """Let every page know whether it drives, and how many watch."""
        for client in visitors.names:
            self._tell(client, "role", {"driving": client == visitors.driver, "watchers": len(visitors.watchers)})

    def place_of(self, client: int) -> Place | None:
        """Where a page looks; None while it sees what it was made to see."""
        handle = self._page.server.get_clients().get(client)
        viewport = self._page.viewport_of(handle) if handle is not None else None
        return None if viewport is None or viewport.fitted else viewport.place

    def _tell(self, client: int, topic: str, value: object) -> None:
        handle = self._page.server.get_clients().get(client)
        if handle is not None:
            self._page.send(topic, value, handle)

    def perform(self, action: str, client: int | None) -> None:
        """Let the script of a page do an action of its own; of every page where nobody asked."""
        self._page.perform(action, self._page.server.get_clients().get(client) if client is not None else None)

    def _bounds(self) -> Bounds:
        return bounds(self._session.map_view, self._session.scan_view)

    def _look(self) -> None:
        session = self._session
        self._turn()
        if session.fit_wanted:
            session.fit_wanted = False
            self.fit()
            if session.place is not None:
                self._camera.look(session.place)
            for client in self._page.server.get_clients():  # not for pages to come: each is told as it is greeted
                self._tell(client, "tab", session.tab)
        elif session.preferences.follow_robot and session.scan_view is not None:
            self._camera.follow(session.scan_view.pose)
        elif session.busy and session.map_view is not self._seen_map:
            self._camera.grow(self._bounds())
        elif self._was_busy and not session.busy:
            self._camera.settle(self._bounds())
        self._was_busy, self._seen_map = session.busy, session.map_view

    def _turn(self) -> None:
        scan, chosen = self._session.scan_view, self._session.preferences
        turn = float(se2.wrap(scan.pose[2] - np.pi / 2)) if chosen.robot_up and scan is not None else 0.0
        if turn != self._turned:
            self._turned = turn
            self._page.send("turn", turn)

    def _timeline(self) -> TimelineState:
        session = self._session
        log, playback = session.log, session.playback
        seconds = log.times[session.cursor] - log.times[0] if log is not None and len(log) else 0.0
        return TimelineState(
            index=session.cursor,
            length=playback.count,
            processed=session.findings.processed,
            playing=playback.playing,
            speed=playback.speed,
            label=f"{seconds:.1f} s",
            marks=self._marks,
        )

    def _say(self, topic: str, value: object) -> None:
        """Give every page a value, if it is another one than before."""
        if topic not in self._said or self._said[topic] != value:
            self._said[topic] = value
            self._page.send(topic, value)

    def _notify(self) -> None:
        notices, self._session.notices = self._session.notices, []
        for notice in notices:
            for client in self._page.server.get_clients().values():
                if notice.client not in (None, client.client_id):
                    continue
                client.add_notification(
                    typeset(notice.title),
                    typeset(notice.text),
                    auto_close_seconds=None if notice.bad else 8.0,
                    color="red" if notice.bad else None,
                )
