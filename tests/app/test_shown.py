"""What is shown follows from what is known, and stays the same object as long as it looks the same."""

from __future__ import annotations

from app.inline import InlineEstimator, deliver
from splinescope import commands as ask
from splinescope.computing import messages as told
from splinescope.session import Session
from splinescope.view import Layer, Selection


def test_the_map_stays_the_same_object_until_something_in_it_changes(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    world, scan = session.map_view, session.scan_view
    session.apply(ask.SetLayer(Layer.TRUTH, True))
    assert session.map_view is world
    assert session.scan_view is scan
    session.apply(ask.Step(-1))
    assert session.map_view is world
    assert session.scan_view is not scan
    session.apply(ask.Optimise())
    deliver(session, inline)
    assert session.map_view is not world


def test_a_key_scan_shows_its_recorded_decisions_and_another_scan_none(
    finished: tuple[Session, InlineEstimator],
) -> None:
    session, _ = finished
    session.apply(ask.Seek(10))
    key = session.scan_view
    session.apply(ask.Step(1))
    other = session.scan_view
    assert key is not None
    assert other is not None
    assert key.key
    assert len(key.associations) > 0
    assert not other.key
    assert not other.associations
    assert len(other.segments) > 0


def test_an_observation_is_taken_apart_once(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    session.apply(ask.Seek(0))
    session.apply(ask.Select(Selection("segment", 0)))
    first = session.observation
    assert session.observation is first
    session.apply(ask.Select(None))
    assert "No segment is selected" in str(session.observation)


def test_a_map_that_changes_loses_its_figures_of_consistency(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    assert session.findings.consistency is not None
    session.apply(ask.Optimise())
    session.receive(next(message for message in inline.messages if isinstance(message, told.Iterated)))
    assert session.findings.consistency is None
    deliver(session, inline)
    assert session.findings.consistency is not None
