"""Actions on what is selected."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action, with_log
from splinescope.pieces import every_piece, name_of_piece
from splinescope.session import Session
from splinescope.view import Selection

NO_SEGMENTS = "This scan has no segments: step to a key scan, which the timeline marks."
NOT_TIED = "Select a segment that was given to a spline first."


def _no_segments(session: Session) -> str | None:
    return None if session.scan_view is not None and session.scan_view.segments else NO_SEGMENTS


def _segment(session: Session) -> int | None:
    chosen = session.selection
    return chosen.id if chosen is not None and chosen.kind == "segment" else None


def neighbour(by: int, session: Session) -> ask.Command:
    """Selects the segment `by` further on in the current scan; the first (or last) where none is selected."""
    scan, now = session.scan_view, _segment(session)
    numbers = [fitted.segment.index for fitted in scan.segments] if scan is not None else []
    if not numbers:
        return ask.Select(None)
    at = numbers.index(now) + by if now in numbers else min(by, 0)
    return ask.Select(Selection("segment", numbers[at % len(numbers)]))


def spline_of_segment(session: Session) -> int | None:
    """The spline that the selected segment was given to; None where there is none."""
    scan, segment = session.scan_view, _segment(session)
    if scan is None or segment is None:
        return None
    return next((a.spline for a in scan.associations if a.segment == segment and a.spline is not None), None)


def _select_spline(session: Session) -> ask.Command:
    spline = spline_of_segment(session)
    return ask.Select(None if spline is None else Selection("spline", spline))


def _all_pieces(session: Session) -> ask.Command:
    scan = session.scan_view
    return ask.SelectPieces(() if scan is None else tuple(map(name_of_piece, every_piece(scan))))


LOOKING = (
    Action("next-segment", "Select the next segment", ("j",), lambda s: neighbour(1, s), _no_segments, repeats=True),
    Action("previous-segment", "Select the one before", ("k",), lambda s: neighbour(-1, s), _no_segments, repeats=True),
    Action(
        "spline-of-segment",
        "Select the spline that the segment was given to",
        ("i",),
        _select_spline,
        lambda session: NOT_TIED if spline_of_segment(session) is None else None,
    ),
    Action("all-pieces", "Select all pieces of the key scan", ("Ctrl+a",), _all_pieces, _no_segments),
    Action("leave", "Put the ruler away, clear the selection", ("Escape",), ask.Leave()),
    Action("measure", "Measure between two things", ("M",), ask.Measure(), with_log),
    Action(
        "observation",
        "Step through the observation of the selected segment, or close it",
        ("s",),
        ask.ShowObservation(),
    ),
    Action("observation-next", "Next step of the observation", ("n",), ask.StepObservation(1)),
    Action("observation-back", "Step back in the observation", ("b",), ask.StepObservation(-1)),
)
