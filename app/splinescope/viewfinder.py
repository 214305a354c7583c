"""Does what is asked for by looking: what is selected, measured, taken apart, shown again or shown elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from bspline_slam.measuring import Picked
from splinescope import commands as ask
from splinescope.browser.link import Link
from splinescope.browser.log_view import LogView
from splinescope.choosing import linked
from splinescope.notice import Notice
from splinescope.observation_view import ObservationView
from splinescope.ruler import Ruler, picked_from
from splinescope.shown import Shown
from splinescope.view import Selection


class Viewfinder:
    """Points what is `shown` at other things; gives commands about time to `do`. State: a link to a moment of a log
    that is not open yet."""

    def __init__(self, shown: Shown, do: Callable[[ask.Command], None]) -> None:
        self._shown, self._do = shown, do
        self._link: Link | None = None

    def apply(self, command: ask.LookingCommand) -> None:
        """Do what a command says."""
        shown = self._shown
        match command:
            case ask.Select(selection=selection):
                self._select(selection)
            case ask.Leave():
                if not shown.editing.leave():
                    shown.ruler, shown.selection = None, None if shown.ruler is None else shown.selection
            case ask.Measure():
                self._measure()
            case ask.LayRuler(picked=picked):
                self._lay_ruler(picked)
            case ask.ShowIteration(number=number):
                shown.replay.show(shown.frames, number)
            case ask.StepIteration(by=by):
                shown.replay.step(shown.frames, by)
            case ask.ShowClosure(number=number):
                self._show_closure(number)
            case ask.LeafThrough(page=page):
                shown.closure_page = page
            case ask.ShowObservation(on=on):
                shown.observing = not shown.observing if on is None else on
            case ask.StepObservation(by=by):
                self._step_observation(by)
            case ask.LookFrom(place=place):
                shown.place = place
            case ask.LookThere():
                shown.look_wanted = shown.around
            case ask.ShowTab(name=name):
                shown.tab = name
            case ask.FollowLink(link=link):
                self._follow(link)

    def look_as_before(self, seen: LogView) -> None:
        """Look at a log that has just been opened as on the last visit, or as a link wants it."""
        shown = self._shown
        shown.following = seen.cursor is None
        if seen.cursor is not None:
            self._do(ask.Seek(seen.cursor))
        shown.selection, shown.place, shown.tab = seen.selection, seen.place, seen.tab
        link, self._link = self._link, None
        if link is not None:
            self._follow(link)

    def _follow(self, link: Link) -> None:
        shown = self._shown
        shown.preferences = linked(shown.preferences, link)
        if link.nonsense:
            shown.tell(Notice("Not all of the link is understood", f"It says {', '.join(link.nonsense)}."))
        if shown.log is None:
            self._link = replace(link, nonsense=())
        elif link.scan is not None:
            self._do(ask.Seek(link.scan))
            self._do(ask.Pause())

    def _select(self, selection: Selection | None) -> None:
        if selection != self._shown.selection:
            self._shown.piece = self._shown.choice = 0
        self._shown.selection = selection

    def _show_closure(self, number: int) -> None:
        """A row that was clicked may be of a list that is gone by now."""
        shown, snapshot = self._shown, self._shown.findings.snapshot
        if snapshot is not None and 0 <= number < len(snapshot.loop_closures):
            self._do(ask.Seek(snapshot.loop_closures[number].scan))
            shown.selection = Selection("closure", number)
            shown.look_wanted = shown.around

    def _step_observation(self, by: int) -> None:
        shown = self._shown
        if shown.observing and isinstance(shown.observation, ObservationView):
            shown.observation_step = shown.observation_step.moved(by)
        shown.observing = True

    def _measure(self) -> None:
        shown = self._shown
        picked = picked_from(shown.selection, shown.scan_view, shown.map_view)
        ruler = shown.ruler or Ruler()
        if picked is not None and picked not in ruler.picked[-1:]:
            self._lay_ruler(picked)
        else:
            shown.ruler = ruler if shown.ruler is None else None

    def _lay_ruler(self, picked: Picked) -> None:
        estimation, ruler = self._shown.estimation, (self._shown.ruler or Ruler()).picking(picked)
        if ruler.first is not None and ruler.second is not None and estimation is not None:
            asked = estimation.measure(ruler.first, ruler.second)
            ruler = replace(ruler, found=asked) if isinstance(asked, str) else replace(ruler, job=asked)
        self._shown.ruler = ruler
