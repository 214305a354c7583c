"""The viewer: one thread that owns the session, fed by one queue of commands and messages.

Callbacks of the page, the opener of logs and the estimator only post to the queue. The loop applies what has come,
lets playback run on, and shows what has changed.
"""

from __future__ import annotations

import getpass
import logging
import os
import queue
import socket
import threading
import time
import webbrowser
from collections.abc import Callable
from pathlib import Path

from bspline_slam.errors import SplineSlamError
from bspline_slam.logs import open_log
from splinescope import commands as ask
from splinescope.actions import Answer, Perform
from splinescope.attendant import Attendant
from splinescope.browser import preferences as prefs
from splinescope.browser.addresses import told_addresses
from splinescope.browser.asker import asker
from splinescope.browser.page import Page, open_page
from splinescope.computing.editor import Editor
from splinescope.computing.messages import Message
from splinescope.computing.worker import Worker
from splinescope.edits.journals import Journals
from splinescope.guide import Guide
from splinescope.notice import Notice
from splinescope.panels import closures, decisions, edit_lists
from splinescope.posted import Arrival, Barrier, Box, Click, FromEditor, Goodbye, Hello, PageMoved, Posted
from splinescope.presenter import Presenter
from splinescope.reception import Reception
from splinescope.session import Session
from splinescope.view import Selection

logger = logging.getLogger(__name__)

ROWS: dict[str, Callable[[int], ask.Command]] = {
    closures.ROW: ask.ShowClosure,
    edit_lists.STATE: ask.GoToEdit,
    edit_lists.SWITCH: ask.SwitchEdit,
    edit_lists.WORST: ask.ShowWorst,
    edit_lists.DOUBT: ask.ShowDoubt,
    decisions.ROW: lambda number: ask.Select(Selection("segment", number)),
}
"""What a click on a row of a table asks for, by the name of its rows."""

KEEPING = 1.0
"""Seconds between two times that choices are written down."""


def view(
    log: Path,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    browser: bool = True,
    session: Path | None = None,
) -> None:
    """Serve the page until interrupted, with `log` being processed.

    `session` is the file that remembers layers and theme. Raises SplineSlamError when the address cannot be had.
    """
    viewer = Viewer(open_page(host, port, title="SplineScope"), session or prefs.default_path())
    viewer.post(ask.OpenLog(log))
    print(*viewer.addresses, sep="\n", flush=True)  # noqa: T201
    if browser:
        threading.Thread(target=webbrowser.open, args=(viewer.address,), daemon=True).start()
    try:
        viewer.run()
    except KeyboardInterrupt:
        logger.info("interrupted")
    finally:
        viewer.close()


class Viewer:
    """Page, estimator and session, tied together by the queue."""

    def __init__(self, page: Page, preferences: Path) -> None:
        self._page = page
        self._preferences_path = preferences
        self._inbox: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
        self._stopped = threading.Event()
        self._worker = Worker(self.post)
        self._worker.start()
        self._editor = Editor(lambda message: self.post(FromEditor(message)))
        journals = Journals.of_user() if preferences == prefs.default_path() else Journals.beside(preferences)
        self.session = Session(
            self._worker, self._open, prefs.load(preferences), editor=self._editor, journals=journals
        )
        self._guide = Guide(self.session)
        self._presenter = Presenter(page, self.session, self._guide, self.post)
        self._reception = Reception(self.session, self._presenter)
        self._attendant = Attendant(self.session, self._presenter, self._reception, self._guide)
        self._watchers: list[Callable[[], None]] = []
        self._told = -1
        self._kept = self.session.preferences
        self._keep_time = 0.0
        page.on_action(lambda action: self.post(Perform(action)))
        page.on_click(lambda point, scale, client: self.post(Click(point, scale)))
        page.on_add(lambda point, scale, client: self.post(Click(point, scale, adds=True)))
        page.on_box(lambda corners: self.post(Box(corners)))
        page.on_timeline(self._timeline)
        page.on_row(self._row)
        page.on_view(lambda: self.post(PageMoved()))
        page.on_hello(lambda *told: self.post(Hello(*told)))
        page.on_goodbye(lambda client: self.post(Goodbye(client)))
        page.on_answer(lambda action, text: self.post(Answer(action, text)))
        page.on_tab(lambda name: self.post(ask.ShowTab(name)))

    @property
    def url(self) -> str:
        """Where the page is, seen from this machine."""
        return self._page.url

    @property
    def address(self) -> str:
        """The same, with the token that it may need."""
        return self._page.address

    @property
    def addresses(self) -> list[str]:
        """Where the page is, in lines for the terminal."""
        page = self._page
        names = (socket.gethostname(), getpass.getuser())
        return told_addresses(page.host, page.server.get_port(), page.token, *names, os.environ)

    # -- from other threads --------------------------------------------------------------------------------------
    def post(self, item: Posted) -> None:
        """Hand something to the owner thread."""
        self._inbox.put(Arrival(item, asker()))

    def caught_up(self, seconds: float | None = None) -> bool:
        """Wait until all that was posted before is done, but no longer than so many seconds; whether it is."""
        barrier = Barrier(threading.Event())
        self.post(barrier)
        return barrier.passed.wait(seconds)

    def on_change(self, callback: Callable[[], None]) -> None:
        """Call back, on the owner's thread, whenever something in the session has changed."""
        self._watchers.append(callback)

    def stop(self) -> None:
        """Let `run` return."""
        self._stopped.set()

    def _timeline(self, command: str, value: float) -> None:
        match command:
            case "seek":
                self.post(ask.Seek(int(value)))
            case "speed":
                self.post(ask.SetSpeed(value))

    def _row(self, name: str, number: int) -> None:
        if (make := ROWS.get(name)) is not None:
            self.post(make(number))

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
            for arrival in self._arrivals():
                self._guarded(lambda arrival=arrival: self._take(arrival.item, arrival.client))
                self._presenter.lead(arrival.client)
            self._guarded(self._reception.greet_known)
            self.session.tick()
            self._guarded(self._guide.tick)
            self._presenter.lead(None)
            self._guarded(self._presenter.show)
            self._guarded(self._tell_of_changes)
            self._remember()

    def close(self) -> None:
        """End the estimator and the page, with all choices kept."""
        self._keep_time = 0.0
        self._remember()
        self._worker.close()
        self._editor.close()
        self.session.editing.close()
        self._page.stop()

    def _arrivals(self) -> list[Arrival]:
        """What has come since the last time, or until something must be shown; of seeks in a row only the newest."""
        items: list[Arrival] = []
        try:
            items.append(self._inbox.get(timeout=self._presenter.seconds_idle))
            while True:
                item = self._inbox.get_nowait()
                if isinstance(item.item, ask.Seek) and isinstance(items[-1].item, ask.Seek):
                    items.pop()
                items.append(item)
        except queue.Empty:
            return items

    def _take(self, item: Posted, client: int | None = None) -> None:
        if client is not None and not self._reception.admits(item, client):
            return
        match item:
            case Hello() if client is not None:
                self._reception.receive(client, item)
            case Barrier(passed=passed):
                passed.set()
            case Goodbye():
                self._reception.left(item.client)
            case Perform():
                self._attendant.perform(item.action, client)
            case Answer():
                self._attendant.answer(item)
            case Click():
                self._attendant.click(item)
            case Box():
                self._attendant.box(item)
            case PageMoved():
                self._presenter.page_moved()
                if client is not None and self._reception.is_driven_by(client):
                    self.session.apply(ask.LookFrom(self._presenter.place_of(client)))
            case Message():
                self._editor.start()  # once the estimator is at work, so that both do not load their modules at once
                self.session.receive(item)
            case Hello():
                logger.warning("a page that is not connected said hello")
            case FromEditor():
                self.session.hear(item.message)
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
                self.session.tell(Notice("Something went wrong", sentence, bad=True))

    def _tell_of_changes(self) -> None:
        if self.session.revision != self._told:
            self._told = self.session.revision
            for callback in self._watchers:
                callback()

    def _remember(self) -> None:
        """Keep what was chosen, at most once a second."""
        now = time.monotonic()
        if now - self._keep_time < KEEPING:
            return
        self._keep_time, chosen = now, self.session.remembered
        if chosen != self._kept:
            self._kept = chosen
            prefs.save(chosen, self._preferences_path)
