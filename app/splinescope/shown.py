"""What the page shows and all that it is made of; everybody reads it, commands and messages change it."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from bspline_slam.edits.edit import Edit
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Snapshot
from splinescope.activity import Activity
from splinescope.browser.link import Link
from splinescope.browser.log_view import LogView
from splinescope.browser.preferences import Preferences
from splinescope.browser.values import Bounds, Place
from splinescope.closures import ClosurePage
from splinescope.computing.solution import Solution
from splinescope.edits.editing import Editing
from splinescope.edits.proposal import asks
from splinescope.edits.subject import EditKind, Subject, edits_for, subject_of
from splinescope.estimation import Estimation
from splinescope.findings import Findings
from splinescope.ghost_view import ghost_view
from splinescope.map_view import view_map
from splinescope.notice import Notice
from splinescope.observation_view import ObservationStep, ObservationView, view_observation
from splinescope.playback import Playback
from splinescope.recipe import Recipe
from splinescope.replay import Frames, Replay
from splinescope.result import Result, Results
from splinescope.ruler import Ruler, places
from splinescope.surroundings import surroundings
from splinescope.view import GhostView, MapView, ScanView, Selection, View

NO_LOG = "No log is open."


class Shown:
    """The state of the page, and what follows from it: views are the same objects as long as they look the same.

    `findings` is what is known of the open log and `estimation` the work on it (None: no log is open). `revision` grows
    with every change; `notices`, `fit_wanted` and `look_wanted`, what a page is led to, are for the viewer to take; a
    fit goes to `place`, where the log was looked at before, and opens `tab`. `piece` counts the pieces of a selected
    segment, and `choice` the targets near what is selected.
    """

    def __init__(self, preferences: Preferences, editing: Editing) -> None:
        self.preferences = preferences
        self.editing = editing
        self.revision = 0
        self.notices: list[Notice] = []
        self.troubles: tuple[str, ...] = ()
        self.fit_wanted = False
        self.look_wanted: Bounds | None = None
        self.title = ""
        self.findings = Findings()
        self.estimation: Estimation | None = None
        self.recipe = Recipe()
        self.playback = Playback(speed=preferences.speed)
        self.following = True
        self.selection: Selection | None = None
        self.piece = self.choice = 0
        self.place: Place | None = None
        self.tab = ""
        self.ruler: Ruler | None = None
        self.replay = Replay()
        self.closure_page = ClosurePage()
        self.observing = False
        self.observation_step = ObservationStep.PARAMETERS
        self._compared_view = lru_cache(maxsize=1)(_plain_view)
        self._observation = lru_cache(maxsize=1)(_observation)
        self._subject = lru_cache(maxsize=1)(subject_of)
        self._ghost = lru_cache(maxsize=1)(ghost_view)

    def tell(self, notice: Notice) -> None:
        """Say something: at once, and what is bad readable for later."""
        self.revision += 1
        self.notices.append(notice)
        if notice.bad:
            self.troubles = (*self.troubles, notice.text)[-3:]

    # -- the log under the cursor --------------------------------------------------------------------------------
    @property
    def log(self) -> ScanLog | None:
        return self.findings.log

    @property
    def cursor(self) -> int:
        return self.playback.cursor

    @property
    def map_view(self) -> MapView | None:
        return self.findings.map_view

    @property
    def scan_view(self) -> ScanView | None:
        """The scan under the cursor."""
        return self.findings.scan_view(self.cursor)

    @property
    def view(self) -> View:
        """One frame of the page."""
        chosen, editing = self.preferences, self.editing
        world, scan = self._replayed or (self.map_view, self.scan_view)
        measured = places(self.ruler, world) if self.ruler is not None and world is not None else None
        wanted = asks(editing.picking, editing.proposal, editing.draft is not None)
        seen = (world, scan, chosen.layers, self.selection, chosen.dark, self.compared_view)
        return View(*seen, chosen.colouring, measured, self.ghost, wanted)

    @property
    def observation(self) -> ObservationView | str:
        """The selected segment of the current key scan taken apart, or why there is none."""
        recipe = self.estimation.recipe if self.estimation is not None else Recipe()
        return self._observation(self.scan_view, self.map_view, self.selection, recipe)

    @property
    def around(self) -> Bounds | None:
        """The rectangle around what is selected, or else around the robot; None where nothing is shown."""
        return surroundings(self.scan_view, self.map_view, self.subject, self.selection)

    @property
    def lost_scans(self) -> list[int]:
        """Indices of the scans lost so far, increasing."""
        return sorted(step.scan for step in self.findings.steps.values() if step.lost)

    # -- hand edits ----------------------------------------------------------------------------------------------
    @property
    def subject(self) -> Subject:
        """What is selected, as the subject of an edit."""
        return self._subject(self.selection, self.scan_view, self.map_view, self.piece)

    @property
    def target(self) -> int | None:
        """The spline that what is selected would be given to or merged with."""
        targets = self.subject.targets
        return targets[self.choice % len(targets)] if targets else None

    def edits(self, kind: EditKind, point: Float[np.ndarray, "2"] | None = None) -> tuple[Edit, ...] | str:
        """The edits of a kind on what is selected, or why there are none; `point` is a place that was clicked."""
        return edits_for(kind, self.subject, self.target, self.editing.next_id, point)

    def edit_refusal(self, kind: EditKind) -> str | None:
        """What stands in the way of an edit of this kind now."""
        wanted = self.editing.refusal or self.edits(kind)
        return wanted if isinstance(wanted, str) else None

    @property
    def ghost(self) -> GhostView | None:
        """What hand edits would change."""
        editing = self.editing
        automatic = editing.base.snapshot if editing.base is not None and editing.explanation is not None else None
        edits = editing.history.active
        return self._ghost(editing.proposal, editing.draft, edits, automatic, self.findings.snapshot)

    # -- iterations shown again ----------------------------------------------------------------------------------
    @property
    def frames(self) -> Frames:
        """The iterations that are kept of the solve behind the result shown; none while another one is being made."""
        result = self.result
        return () if result is None or self.busy or self.findings.snapshot is not result.snapshot else result.frames

    @property
    def frame(self) -> int | None:
        """Which of them is shown; None for the result."""
        return self.replay.number(self.frames)

    @property
    def _replayed(self) -> tuple[MapView, ScanView | None] | None:
        """Map and scan at the iteration shown; None for the result."""
        result, scan = self.result, self.scan_view
        if result is None or self.log is None:
            return None
        played = self.replay.map(self.frames, self.log, result.snapshot)
        if played is None:
            return None
        snapshot, world = played
        if scan is not None and self.cursor < len(snapshot.poses):
            scan = replace(scan, pose=snapshot.poses[self.cursor])
        return world, scan

    # -- work and results ----------------------------------------------------------------------------------------
    @property
    def activity(self) -> Activity | None:
        """The running job; edits that are being made come first."""
        return self.editing.activity or (self.estimation.activity if self.estimation is not None else None)

    @property
    def busy(self) -> bool:
        """The map is being changed right now."""
        return self.estimation is not None and self.estimation.busy

    @property
    def solution(self) -> Solution | None:
        """The figures behind the result shown."""
        return self.estimation.solution if self.estimation is not None else None

    @property
    def costs(self) -> tuple[float, ...]:
        """The cost after each iteration of the running or latest solve."""
        return self.estimation.costs if self.estimation is not None else ()

    @property
    def refusal(self) -> str | None:
        """A sentence on what stands in the way of optimising now; None if nothing does."""
        return self.estimation.solve_refusal(self.recipe) if self.estimation is not None else NO_LOG

    @property
    def run_refusal(self) -> str | None:
        """A sentence on what stands in the way of running over the log now; None if nothing does."""
        return self.estimation.run_refusal(self.recipe) if self.estimation is not None else NO_LOG

    @property
    def results(self) -> Results:
        """All that was made of the open log."""
        return self.estimation.results if self.estimation is not None else Results()

    @property
    def result(self) -> Result | None:
        """The result that is shown; while another one is being made, the one shown before."""
        return self.results.shown

    @property
    def compared(self) -> Result | None:
        """The result that is laid over what is shown: the chosen one, or the last one while a new one is made."""
        return self.results.shown if self.busy else self.results.compared

    @property
    def compared_view(self) -> MapView | None:
        """That result as the page draws it."""
        result = self.compared
        return None if result is None or self.log is None else self._compared_view(self.log, result.snapshot)

    # -- for later -----------------------------------------------------------------------------------------------
    @property
    def remembered(self) -> Preferences:
        """What is to be kept for the next visit: the preferences, with how the open log is looked at."""
        if self.log is None or not len(self.log):
            return self.preferences
        cursor = None if self.following else self.cursor
        seen = LogView(cursor, self.place, self.selection, self.tab)
        return self.preferences.with_view(self.log.content_hash, seen)

    @property
    def link(self) -> Link:
        """This moment, but for the place that each page looks at."""
        chosen = self.preferences
        return Link(self.cursor if self.log is not None else None, chosen.layers, None, chosen.colouring)


def _plain_view(log: ScanLog, snapshot: Snapshot) -> MapView:
    return view_map(log, snapshot, {})


def _observation(
    scan: ScanView | None, world: MapView | None, selection: Selection | None, recipe: Recipe
) -> ObservationView | str:
    return view_observation(scan, world, selection, recipe.config())
