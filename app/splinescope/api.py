"""The workbench from Python and from notebooks: what a program asks for, every page shows.

    from splinescope.api import open_workbench

    scope = open_workbench("office")             # a sample or a path; serves the page and opens a browser
    scope.wait()                                 # until the log is processed
    scope.on_selection(print)                    # whenever somebody selects something, in any page
    scope.seek(300)
    scope.step(-1)
    print(scope.solve().chi2_per_dof)
    scope.force(scan=299, segment=2, spline=17)  # by hand: scope.undo() takes it back
    print(scope.poses.shape, len(scope.map))
    scope.close()

A workbench posts the same commands as a page, so it cannot do what a page cannot, and a page never shows less than it
knows. Callbacks run on a thread of their own: they may ask for more. A script calls it below
`if __name__ == "__main__":`, for the estimator is a process of its own.
"""

from __future__ import annotations

import logging
import queue
import threading
import webbrowser
from collections.abc import Callable
from html import escape
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.edits.edit import Edit, Force
from bspline_slam.errors import ConfigError, EditError, SolverError, SplineSlamError
from bspline_slam.spline_map import SplineMap
from splinescope import commands as ask
from splinescope.browser import preferences as prefs
from splinescope.browser.page import open_page
from splinescope.computing.solution import Solution
from splinescope.log_choice import first_log
from splinescope.paths import find_log
from splinescope.recognition import recognition
from splinescope.session import Session
from splinescope.view import Selection
from splinescope.viewer import Viewer

logger = logging.getLogger(__name__)


def open_workbench(
    log: str | Path | None = None,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    browser: bool = True,
    session: Path | None = None,
) -> Workbench:
    """Serve the page with a log, given by its path or the name of a sample, that is being processed from now on;
    without one, with that of the session, else with a sample.

    Raises SplineSlamError where it cannot be read, ConfigError where the address cannot be had, where `session` is no
    session's file, and where its log is gone. `session` is the file that remembers layers and views; that its log has
    moved or changed since is logged as a warning. `port` 0 takes any free one.
    """
    found = first_log(None if log is None else str(log), session)
    scope = Workbench(Viewer(open_page(host, port, title="SplineScope"), session or prefs.default_path()))
    try:
        scope.open(found)
    except SplineSlamError:
        scope.close()
        raise
    if browser:
        webbrowser.open(scope.url)
    return scope


class Workbench:
    """A running viewer. All methods may be called from any thread; properties show what is known at that moment."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._changed = threading.Condition()
        self._news: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._selected: list[Callable[[Selection | None], None]] = []
        self._selection: Selection | None = None
        self._edited: list[Callable[[tuple[Edit, ...]], None]] = []
        self._edits: tuple[Edit, ...] = ()
        viewer.on_change(self._notice)
        self._threads = [threading.Thread(target=each, daemon=True) for each in (viewer.run, self._tell)]
        for thread in self._threads:
            thread.start()

    # -- what is known -------------------------------------------------------------------------------------------
    @property
    def url(self) -> str:
        """Where the page is, with the token that it may need."""
        return self._viewer.address

    @property
    def session(self) -> Session:
        """Everything that the page shows: look, but change it by commands alone."""
        return self._viewer.session

    @property
    def cursor(self) -> int:
        """Index of the scan that is shown."""
        return self.session.cursor

    @property
    def selection(self) -> Selection | None:
        """What is selected."""
        return self.session.selection

    @property
    def poses(self) -> Float[np.ndarray, "scans 3"]:
        """The estimated pose (x, y, θ) of every scan so far."""
        snapshot = self.session.findings.snapshot
        return np.zeros((0, 3)) if snapshot is None else snapshot.poses

    @property
    def map(self) -> SplineMap:
        """The map so far."""
        snapshot = self.session.findings.snapshot
        return SplineMap() if snapshot is None else snapshot.map

    def _repr_html_(self) -> str:
        url = escape(self.url)
        return f'SplineScope: <a href="{url}" target="_blank">{url}</a>'

    # -- what can be asked ---------------------------------------------------------------------------------------
    def do(self, command: ask.Command) -> None:
        """Apply any command, as a page would; returns when it is done."""
        self._viewer.post(command)
        self._viewer.caught_up()

    def open(self, log: str | Path) -> None:
        """Open a log, by its path or the name of a sample, and begin to process it; one that has moved or changed since
        the session referred to it is warned of. Raises SplineSlamError."""
        request = ask.OpenLog(find_log(str(log)))
        before, visit = len(self.session.troubles), self.session.preferences
        self.do(request)
        self._until(lambda: self.session.opening != request)
        if self.session.log is None or len(self.session.troubles) > before:
            raise SplineSlamError(self.session.troubles[-1])
        for notice in recognition(self.session.log, visit):
            logger.warning("%s: %s", notice.title, notice.text)

    def seek(self, index: int) -> None:
        """Show scan `index`; −1 is the last one."""
        self.do(ask.Seek(index))

    def step(self, by: int = 1) -> None:
        """Show the scan `by` further on."""
        self.do(ask.Step(by))

    def select(self, selection: Selection | None) -> None:
        """Select one thing, or nothing."""
        self.do(ask.Select(selection))

    def force(self, scan: int, segment: int, spline: int) -> None:
        """Overrule the estimator: all beams of this segment of a key scan saw this spline. It is one edit, kept in the
        journal, and can be undone in the page. Raises EditError, in a sentence, where it cannot be made."""
        step = self.session.findings.steps.get(scan)
        pieces = [a for a in step.associations if a.segment == segment] if step is not None else []
        if not pieces:
            raise EditError(f"key scan {scan} has no segment {segment} that was associated")
        self.edit(*(Force(scan, segment, each.first, each.last, spline) for each in pieces))

    def edit(self, *edits: Edit) -> None:
        """Make edits as one action, without a preview. Raises EditError, in a sentence, where they cannot be made."""
        if self.session.editing.refusal is not None:
            raise EditError(self.session.editing.refusal)
        self.do(ask.ProposeEdits(edits))
        self.do(ask.AcceptEdits())

    def undo(self) -> None:
        """Take back the last action of the history of edits."""
        self.do(ask.Undo())

    @property
    def edits(self) -> tuple[Edit, ...]:
        """The edits in force."""
        return self.session.editing.history.active

    def wait(self, seconds: float | None = None) -> None:
        """Until the estimator has nothing to do. Raises TimeoutError, and SolverError where a job failed meanwhile."""
        before = self.session.troubles
        self._until(self._idle, seconds)
        if self.session.troubles != before:
            raise SolverError(self.session.troubles[-1])

    def solve(self, seconds: float | None = None) -> Solution:
        """Solve the map that is shown again, and wait for it. Raises ConfigError, in a sentence, where that is
        impossible now, and SolverError where it comes to nothing."""
        if self.session.refusal is not None:
            raise ConfigError(self.session.refusal)
        made = self.session.results.made
        self.do(ask.Optimise())
        self._until(lambda: not self.session.busy, seconds)
        if self.session.results.made == made or self.session.solution is None:
            raise SolverError("the map could not be solved; the page says why")
        return self.session.solution

    # -- what can be listened to ---------------------------------------------------------------------------------
    def on_selection(self, callback: Callable[[Selection | None], None]) -> None:
        """Call back with what is selected whenever that has changed, whoever did it."""
        self._selected.append(callback)

    def on_edits(self, callback: Callable[[tuple[Edit, ...]], None]) -> None:
        """Call back with the edits in force whenever these have changed, whoever did it."""
        self._edited.append(callback)

    def close(self) -> None:
        """End the page and the estimator."""
        self._viewer.stop()
        self._threads[0].join(10)
        self._news.put(None)
        self._viewer.close()

    def __enter__(self) -> Workbench:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # -- the viewer's thread and the callbacks' thread -----------------------------------------------------------
    def _notice(self) -> None:
        selection = self.session.selection
        if selection != self._selection:
            self._selection = selection
            for callback in self._selected:
                self._news.put(lambda callback=callback: callback(selection))
        edits = self.session.editing.history.active
        if edits != self._edits:
            self._edits = edits
            for callback in self._edited:
                self._news.put(lambda callback=callback: callback(edits))
        with self._changed:
            self._changed.notify_all()

    def _tell(self) -> None:
        while (news := self._news.get()) is not None:
            news()

    def _idle(self) -> bool:
        session = self.session
        return session.activity is None and session.opening is None and not session.editing.making

    def _until(self, condition: Callable[[], Any], seconds: float | None = None) -> None:
        """Wait until a condition holds, also after the viewer is through with what it was doing: half of a change would
        do otherwise."""
        held = False
        while not held:
            with self._changed:
                if not self._changed.wait_for(condition, seconds):
                    raise TimeoutError(f"the workbench was not ready after {seconds:g} s")
            self._viewer.caught_up()
            held = condition()
