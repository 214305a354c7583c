"""The attendant: does what people ask for at a page by clicks, boxes, actions and answers."""

from __future__ import annotations

import logging

from bspline_slam.errors import SplineSlamError, as_sentence
from splinescope import commands as ask
from splinescope.actions import Action, Answer, PageRequest, find
from splinescope.guide import Guide
from splinescope.notice import Notice
from splinescope.picking import pick, pick_box, pick_piece
from splinescope.posted import Box, Click
from splinescope.presenter import Presenter
from splinescope.reception import Reception
from splinescope.ruler import picked_from
from splinescope.session import Session

logger = logging.getLogger(__name__)

CLICK_PIXELS = 8.0
"""So far from a thing a click still means it."""
NOT_MEASURABLE = Notice("Nothing to measure there", "Click a curve of the map, a control point or a key pose.")
NO_PIECE = Notice("Nothing to add there", "Shift adds pieces of the segments of a key scan.")


class Attendant:
    """Turns what a person did into commands of the session, or into what their page alone is shown."""

    def __init__(self, session: Session, presenter: Presenter, reception: Reception, guide: Guide) -> None:
        self._session, self._presenter, self._reception, self._guide = session, presenter, reception, guide

    def click(self, click: Click) -> None:
        """Choose, add, measure or select what lies at a place of the map, whichever is being done."""
        session, near = self._session, CLICK_PIXELS * click.metres_per_pixel
        if session.editing.picking or session.editing.draft:
            x, y = click.point.tolist()
            session.apply(ask.PickPlace(x, y, near))
        elif click.adds:
            self._add(click, near)
        elif session.ruler is None:
            session.apply(ask.Select(pick(session.view, click.point, near)))
        else:
            self._measure(click, near)

    def box(self, box: Box) -> None:
        """Select all pieces in a rectangle."""
        self._session.apply(ask.SelectPieces(pick_box(self._session.view, box.corners)))

    def perform(self, name: str, client: int | None) -> None:
        """Do the action of this id for the page that asks, or say why not."""
        action, session = find(name), self._session
        if action is None:
            logger.warning("no action is called %.80s", name)
            return
        if self._refused(action):
            return
        match action.request(session):
            case PageRequest() as request:
                self._show(request, name, client)
            case command:
                session.apply(command)

    def answer(self, answer: Answer) -> None:
        """Do what has asked a question, now that it is answered."""
        action, session = find(answer.action), self._session
        if action is None or action.asks is None:
            logger.warning("no question is called %.80s", answer.action)
            return
        if self._refused(action):
            return
        try:
            session.apply(action.asks.command(answer.text))
        except SplineSlamError as error:
            session.tell(Notice(action.words, as_sentence(str(error))))

    def _refused(self, action: Action) -> bool:
        """Say why an action cannot be done, if it cannot."""
        refusal = action.refusal(self._session)
        if refusal is not None:
            self._session.tell(Notice(action.words, refusal))
        return refusal is not None

    def _add(self, click: Click, near: float) -> None:
        found = pick_piece(self._session.view, click.point, near)
        if found is not None:
            self._session.apply(ask.TogglePiece(found))
        else:
            self._session.tell(NO_PIECE)

    def _measure(self, click: Click, near: float) -> None:
        session = self._session
        found = pick(session.view, click.point, near)
        picked = picked_from(found, session.scan_view, session.map_view, click.point)
        if picked is None:
            session.tell(NOT_MEASURABLE)
        else:
            session.apply(ask.LayRuler(picked))

    def _show(self, request: PageRequest, name: str, client: int | None) -> None:
        """Do what concerns pages and not the session."""
        match request:
            case PageRequest.FIT:
                self._presenter.fit(client)
            case PageRequest.FIT_SCAN:
                self._presenter.fit_scan(client)
            case PageRequest.TOUR:
                self._tour(name)
            case PageRequest.TAKE_CONTROL if client is not None:
                self._reception.drive(client)
            case PageRequest.LINK if client is not None:
                self._presenter.copy_link(client)
            case PageRequest.SCRIPT | PageRequest.ASK:
                self._presenter.perform(name, client)
            case _:
                logger.warning("%s concerns a page, but none has asked", name)

    def _tour(self, name: str) -> None:
        match name:
            case "tour":
                self._guide.start()
            case "tour-end":
                self._guide.end()
            case _:
                self._guide.step(-1 if name == "tour-back" else 1)
        self._session.revision += 1
