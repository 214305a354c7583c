"""The viewer: one thread that owns session and scene, fed by one queue of commands and messages.

Callbacks of the page, the log opener and the estimator only post to the queue. The loop applies what has come, lets
playback run on, and draws at most DRAWS_PER_SECOND times a second, and only when something changed.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam.errors import SplineSlamError
from bspline_slam.logs import open_log
from splinescope import commands as ask
from splinescope import preferences as prefs
from splinescope.camera import Camera, bounds
from splinescope.keys import PageAction, binding_of
from splinescope.messages import Message
from splinescope.page import Bounds, Mark, Page, TimelineState, open_page
from splinescope.panels.help import HelpSheet
from splinescope.panels.side_bar import SideBar
from splinescope.paths import find_log
from splinescope.picking import pick
from splinescope.scene import Scene
from splinescope.session import Session
from splinescope.view import MapView
from splinescope.worker import Worker

logger = logging.getLogger(__name__)

DRAWS_PER_SECOND = 30.0
PANELS_PER_SECOND = 8.0
CLICK_PIXELS = 8.0
FIRST_SAMPLE = "office"


@dataclass(frozen=True, eq=False, slots=True)
class Click:
    """A person clicked the map at `point` (world frame)."""

    point: Float[np.ndarray, "2"]
    metres_per_pixel: float


@dataclass(frozen=True, slots=True)
class PageMoved:
    """Some page sees another part of the world, or a new page has come."""


Posted = ask.Command | PageAction | Click | PageMoved | Message


def view(
    log: Path | None,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    browser: bool = True,
    session: Path | None = None,
) -> None:
    """Serve the page until interrupted, with `log` (or the first sample) being processed.

    `session` is the file that remembers layers and theme. Raises SplineSlamError when the address cannot be had.
    """
    page = open_page(host, port, title="SplineScope")
    viewer = Viewer(page, session or prefs.default_path())
    viewer.post(ask.OpenLog(log or find_log(FIRST_SAMPLE)))
    print(f"SplineScope is at {viewer.url}   (Ctrl+C ends it)", flush=True)  # noqa: T201
    if browser:
        threading.Thread(target=webbrowser.open, args=(viewer.url,), daemon=True).start()
    try:
        viewer.run()
    except KeyboardInterrupt:
        logger.info("interrupted")
    finally:
        viewer.close()


class Viewer:
    """Page, session, scene and panels, tied together by the queue."""

    def __init__(self, page: Page, preferences: Path) -> None:
        self._page = page
        self._preferences_path = preferences
        self._inbox: queue.SimpleQueue[Posted] = queue.SimpleQueue()
        self._stopped = threading.Event()
        self._worker = Worker(self.post)
        self._worker.start()
        self.session = Session(self._worker, self._open, prefs.load(preferences))
        self._scene = Scene(page)
        self._camera = Camera(page)
        self._side_bar = SideBar(page.server.gui, self.post)
        self._help = HelpSheet(page.server.gui, self.post)
        self._kept = self.session.preferences
        self._drawn = self._refreshed = self._marked = -1
        self._draw_time = self._panel_time = self._mark_time = 0.0
        self._marks: tuple[Mark, ...] = ()
        self._was_busy = False
        self._seen_map: MapView | None = None
        self._listen()

    @property
    def url(self) -> str:
        """Where the page is."""
        return self._page.url

    # -- from other threads --------------------------------------------------------------------------------------
    def post(self, item: Posted) -> None:
        """Hand something to the owner thread."""
        self._inbox.put(item)

    def stop(self) -> None:
        """Let `run` return."""
        self._stopped.set()

    def _listen(self) -> None:
        self._page.on_key(self._key)
        self._page.on_click(lambda point, scale, client: self.post(Click(point, scale)))
        self._page.on_timeline(self._timeline)
        self._page.on_view(lambda: self.post(PageMoved()))

    def _key(self, name: str) -> None:
        binding = binding_of(name)
        if binding is not None:
            self.post(binding.does)

    def _timeline(self, command: str, value: float) -> None:
        match command:
            case "play":
                self.post(ask.Play())
            case "pause":
                self.post(ask.Pause())
            case "seek":
                self.post(ask.Seek(int(value)))
            case "step":
                self.post(ask.Step(int(value)))
            case "speed":
                self.post(ask.SetSpeed(value))

    def _open(self, request: ask.OpenLog) -> None:
        threading.Thread(target=self._read, args=(request,), daemon=True).start()

    def _read(self, request: ask.OpenLog) -> None:
        try:
            self.post(ask.LogOpened(request, open_log(request.path)))
        except SplineSlamError as error:
            self.post(ask.LogRefused(request, str(error)))
        except Exception as error:
            logger.exception("cannot open %s", request.path)
            self.post(ask.LogRefused(request, f"{request.path.name} cannot be read ({type(error).__name__}: {error})"))

    # -- the owner thread ----------------------------------------------------------------------------------------
    def run(self) -> None:
        """The loop; returns after `stop`."""
        while not self._stopped.is_set():
            for item in self._arrivals():
                self._guarded(lambda item=item: self._take(item))
            self.session.tick()
            self._guarded(self._draw)

    def close(self) -> None:
        """End the estimator and the page."""
        self._worker.close()
        self._page.stop()

    def _arrivals(self) -> list[Posted]:
        """What has come since the last time, after a wait of at most a frame; of seeks in a row only the newest."""
        idle = not self.session.playback.playing and self._refreshed == self.session.revision
        items: list[Posted] = []
        try:
            items.append(self._inbox.get(timeout=0.25 if idle else 1.0 / DRAWS_PER_SECOND))
            while True:
                item = self._inbox.get_nowait()
                if isinstance(item, ask.Seek) and isinstance(items[-1], ask.Seek):
                    items.pop()
                items.append(item)
        except queue.Empty:
            return items

    def _take(self, item: Posted) -> None:
        match item:
            case PageAction():
                self._act(item)
            case Click():
                self._click(item)
            case PageMoved():
                self._drawn = -1 if self._scene.stale else self._drawn
                self._camera.welcome(self._bounds())
            case Message():
                self.session.receive(item)
            case _:
                self.session.apply(item)

    def _guarded(self, work: Callable[[], None]) -> None:
        """Whatever goes wrong is told to the person and ends nothing; said once while it goes on."""
        try:
            work()
        except Exception as error:
            logger.exception("the viewer's loop goes on after an error")
            sentence = f"Something went wrong in the page ({type(error).__name__}: {error})."
            if sentence not in self.session.troubles:
                self.session.complain("Something went wrong", sentence)

    def _act(self, action: PageAction) -> None:
        session = self.session
        match action:
            case PageAction.FIT:
                self._camera.fit(self._bounds())
            case PageAction.HELP:
                self._help.toggle()
            case PageAction.ESCAPE:
                self._help.close()
                session.apply(ask.Select(None))
            case PageAction.OPTIMISE:
                session.apply(ask.Optimise(session.preferences.back_end))
            case PageAction.FOLLOW_PROCESSING:
                session.apply(ask.FollowProcessing(not session.following))
            case PageAction.FOLLOW_ROBOT:
                session.apply(ask.FollowRobot(not session.preferences.follow_robot))

    def _click(self, click: Click) -> None:
        found = pick(self.session.view, click.point, CLICK_PIXELS * click.metres_per_pixel)
        self.session.apply(ask.Select(found))

    # -- drawing -------------------------------------------------------------------------------------------------
    def _draw(self) -> None:
        session, now = self.session, time.monotonic()
        self._notify()
        if session.revision != self._drawn and now - self._draw_time >= 1.0 / DRAWS_PER_SECOND:
            self._draw_time, self._drawn = now, session.revision
            self._draw_scene()
        if session.revision != self._refreshed and now - self._panel_time >= 1.0 / PANELS_PER_SECOND:
            self._panel_time, self._refreshed = now, session.revision
            with self._page.server.atomic():
                self._side_bar.refresh(session)
            self._remember()

    def _draw_scene(self) -> None:
        session = self.session
        self._scene.draw(session.view)
        self._page.timeline(self._timeline_state())
        self._look(session)

    def _look(self, session: Session) -> None:
        if session.fit_wanted:
            session.fit_wanted = False
            self._camera.fit(self._bounds())
        elif session.preferences.follow_robot and session.scan_view is not None:
            self._camera.follow(session.scan_view.pose)
        elif session.busy and session.map_view is not self._seen_map:
            self._camera.grow(self._bounds())
        elif self._was_busy and not session.busy:
            self._camera.settle(self._bounds())
        self._was_busy, self._seen_map = session.busy, session.map_view

    def _bounds(self) -> Bounds:
        return bounds(self.session.map_view, self.session.scan_view)

    def _timeline_state(self) -> TimelineState:
        session = self.session
        count, playback = session.playback.count, session.playback
        seconds = session.log.times[session.cursor] - session.log.times[0] if session.log is not None and count else 0.0
        return TimelineState(
            index=session.cursor,
            length=count,
            processed=session.processed,
            playing=playback.playing,
            speed=playback.speed,
            label=f"{seconds:.1f} s",
            marks=self._marked_scans(),
        )

    def _marked_scans(self) -> tuple[Mark, ...]:
        """Key scans, lost scans and loop closures; made anew at most once a second."""
        session, now = self.session, time.monotonic()
        state = hash((len(session.steps), id(session.snapshot)))
        if state != self._marked and now - self._mark_time >= 1.0:
            self._marked, self._mark_time = state, now
            self._marks = marks(session)
        return self._marks

    def _notify(self) -> None:
        notices, self.session.notices = self.session.notices, []
        for notice in notices:
            for client in self._page.server.get_clients().values():
                client.add_notification(
                    notice.title,
                    notice.text,
                    auto_close_seconds=None if notice.bad else 8.0,
                    color="red" if notice.bad else None,
                )

    def _remember(self) -> None:
        if self.session.preferences != self._kept:
            self._kept = self.session.preferences
            prefs.save(self._kept, self._preferences_path)


def marks(session: Session) -> tuple[Mark, ...]:
    """What there is to find on the timeline."""
    keys = [Mark(step.scan, "lost" if step.lost else "key") for step in session.steps.values() if step.key or step.lost]
    loops = session.snapshot.loop_closures if session.snapshot is not None else ()
    return (*keys, *(Mark(loop.scan, "loop") for loop in loops if loop.accepted))
