"""Shows a session in a page: scene, timeline, panels, camera and notices, each only when and as often as needed."""

from __future__ import annotations

import time

from splinescope.actions import described, refusals
from splinescope.camera import Camera, bounds
from splinescope.page import Bounds, Mark, Page, TimelineState
from splinescope.panels.panel import Post
from splinescope.panels.side_bar import SideBar
from splinescope.scene import Scene
from splinescope.session import Session
from splinescope.view import MapView

DRAWS_PER_SECOND = 30.0
PANELS_PER_SECOND = 8.0
MARKS_PER_SECOND = 1.0
LONGEST_REST = 0.25


class Presenter:
    """Owns the widgets and the drawing of one page; called by the owner of the session alone."""

    def __init__(self, page: Page, session: Session, post: Post) -> None:
        self._page = page
        self._session = session
        self._scene = Scene(page)
        self._camera = Camera(page)
        self._side_bar = SideBar(page.server.gui, post)
        self._refusals: dict[str, str] | None = None
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
        revision = self._session.revision
        if self._session.playback.playing or revision != self._drawn:
            due = self._draw_time + 1.0 / DRAWS_PER_SECOND
        elif revision != self._refreshed:
            due = self._panel_time + 1.0 / PANELS_PER_SECOND
        else:
            return LONGEST_REST
        return max(due - time.monotonic(), 0.001)

    def show(self) -> None:
        """Show what has changed, if its time has come."""
        session, now = self._session, time.monotonic()
        self._notify()
        if session.revision != self._drawn and now - self._draw_time >= 1.0 / DRAWS_PER_SECOND:
            self._draw_time, self._drawn = now, session.revision
            self._scene.draw(session.view)
            self._page.timeline(self._timeline())
            self._look()
        if session.revision != self._refreshed and now - self._panel_time >= 1.0 / PANELS_PER_SECOND:
            self._panel_time, self._refreshed = now, session.revision
            with self._page.server.atomic():
                self._side_bar.refresh(session)
            self._refuse(refusals(session))

    def page_moved(self) -> None:
        """Some page sees another part of the world, or a new one has come."""
        self._camera.welcome(self._bounds())
        if self._scene.stale:
            self._drawn = -1

    def fit(self) -> None:
        """Show the whole map in every page."""
        self._camera.fit(self._bounds())

    def perform(self, action: str, client: int | None) -> None:
        """Let the script of a page do an action of its own; of every page where nobody asked."""
        self._page.perform(action, self._page.server.get_clients().get(client) if client is not None else None)

    def _bounds(self) -> Bounds:
        return bounds(self._session.map_view, self._session.scan_view)

    def _look(self) -> None:
        session = self._session
        if session.fit_wanted:
            session.fit_wanted = False
            self.fit()
        elif session.preferences.follow_robot and session.scan_view is not None:
            self._camera.follow(session.scan_view.pose)
        elif session.busy and session.map_view is not self._seen_map:
            self._camera.grow(self._bounds())
        elif self._was_busy and not session.busy:
            self._camera.settle(self._bounds())
        self._was_busy, self._seen_map = session.busy, session.map_view

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
            marks=self._current_marks(),
        )

    def _current_marks(self) -> tuple[Mark, ...]:
        findings, now = self._session.findings, time.monotonic()
        sources = (findings, len(findings.steps), findings.snapshot)
        if sources != self._marks_of and now - self._mark_time >= 1.0 / MARKS_PER_SECOND:
            self._marks_of, self._mark_time = sources, now
            self._marks = marks(self._session)
        return self._marks

    def _refuse(self, now: dict[str, str]) -> None:
        if now != self._refusals:
            self._refusals = now
            self._page.send("refusals", now)

    def _notify(self) -> None:
        notices, self._session.notices = self._session.notices, []
        for notice in notices:
            for client in self._page.server.get_clients().values():
                client.add_notification(
                    notice.title,
                    notice.text,
                    auto_close_seconds=None if notice.bad else 8.0,
                    color="red" if notice.bad else None,
                )


def marks(session: Session) -> tuple[Mark, ...]:
    """What there is to find on the timeline: key scans, lost scans, loop closures."""
    findings = session.findings
    steps = (step for step in findings.steps.values() if step.key or step.lost)
    loops = findings.snapshot.loop_closures if findings.snapshot is not None else ()
    return (
        *(Mark(step.scan, "lost" if step.lost else "key") for step in steps),
        *(Mark(loop.scan, "loop") for loop in loops if loop.accepted),
    )
