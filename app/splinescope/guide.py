"""The guide: takes a session through the tour, step by step."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.mistake import mistake_in
from splinescope.paths import SAMPLE, find_log
from splinescope.recipe import Recipe
from splinescope.session import Session
from splinescope.tour import STEPS, WAIT, Tour, ready


class Guide:
    """State: the tour that somebody takes, if anybody does. It changes the session by commands alone."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.tour: Tour | None = None

    def start(self) -> None:
        """Begin, on the sample log."""
        session, sample = self._session, find_log(SAMPLE)
        session.apply(ask.Choose(Recipe()))
        if session.log is None or session.log.path != sample:
            session.apply(ask.OpenLog(sample))
        self.tour = Tour()
        session.apply(ask.SeenTour())

    def step(self, by: int) -> None:
        """Go on or back; past the end the tour is over."""
        if self.tour is None:
            return
        if by > 0 and self.tour.step + by >= len(STEPS):
            self.end()
        elif self.tour.mistake is not None:
            self.tour = self.tour.moved(by)
            self._enter()

    def end(self) -> None:
        """Leave the tour, and no mistake behind it."""
        tour, self.tour = self.tour, None
        mistake = tour.mistake if tour is not None else None
        if mistake is not None and self._session.editing.history.active[-1:] == (mistake,):
            self._session.apply(ask.Undo())
        self._session.apply(ask.SeenTour())

    def tick(self) -> None:
        """Go on where the map is ready, or a person has done what the card asks for."""
        tour, session = self.tour, self._session
        if tour is None or not ready(session):
            return
        if tour.mistake is None:
            mistake = mistake_in(session.findings)
            self.tour = None if mistake is None else Tour(mistake=mistake)
            self._enter()
        elif tour.shown.done is not None and tour.shown.done(session, tour.mistake):
            self.step(1)

    @property
    def card(self) -> dict[str, object] | None:
        """What the page shows; None where nobody takes the tour, and an invitation where nobody ever has."""
        if self.tour is None:
            return None if self._session.preferences.toured else {"invitation": True}
        waiting, shown = self.tour.mistake is None, self.tour.shown
        return {
            "title": shown.title,
            "text": WAIT if waiting else shown.text,
            "tab": shown.tab,
            "rows": shown.rows,
            "step": self.tour.step,
            "steps": len(STEPS),
            "waiting": waiting,
            "asks": shown.done is not None,
        }

    def _enter(self) -> None:
        if self.tour is not None and self.tour.mistake is not None:
            for command in self.tour.shown.enter(self._session, self.tour.mistake):
                self._session.apply(command)
