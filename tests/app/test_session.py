"""The state behind the page: logs that are opened, time, what changes when; with an estimator that answers at once."""

from __future__ import annotations

import gc
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.inline import InlineEstimator, deliver, session_with
from app.logs import MemoryLog
from bspline_slam import se2
from splinescope import commands as ask
from splinescope.actions import ACTIONS, PageRequest
from splinescope.activity import Work
from splinescope.browser.preferences import FIRST_LAYERS, Preferences
from splinescope.session import Session
from splinescope.view import Layer, Selection


def test_an_opened_log_can_be_stepped_before_anything_is_processed(log: MemoryLog) -> None:
    session, _ = session_with(log)
    assert session.fit_wanted
    assert session.activity is not None
    assert session.activity.work is Work.PROCESSING
    session.apply(ask.Step(3))
    shown = session.scan_view
    assert shown is not None
    assert log.odometry is not None
    assert shown.scan.index == 3
    assert np.allclose(shown.pose, se2.between(log.odometry[0], log.odometry[3]))
    assert len(shown.segments) > 0
    assert not shown.key
    assert session.map_view is not None
    assert session.map_view.odometry is not None
    assert not len(session.map_view.map)


def test_the_cursor_follows_the_processing_until_a_person_takes_it(log: MemoryLog) -> None:
    session, inline = session_with(log)
    while session.findings.processed == 0:
        session.receive(inline.messages.pop(0))
    assert session.cursor == session.findings.processed - 1
    session.apply(ask.Seek(0))
    deliver(session, inline)
    assert session.cursor == 0
    assert session.findings.processed == len(log)
    session.apply(ask.FollowProcessing(True))
    assert session.cursor == len(log) - 1


def test_what_is_refused_says_why(log: MemoryLog) -> None:
    empty = Session(InlineEstimator(), lambda _: None, Preferences())
    empty.apply(ask.Optimise())
    assert empty.notices[-1].text == "No log is open."
    session, _ = session_with(log)
    session.apply(ask.Optimise())
    assert "still being processed" in session.notices[-1].text


def test_a_bad_log_leaves_the_open_one_alone(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    request = ask.OpenLog(Path("broken.log"))
    session.apply(request)
    assert session.opening == request
    session.apply(ask.LogRefused(request, "broken.log: no scans in it"))
    assert session.opening is None
    assert session.troubles == ("broken.log: no scans in it",)
    assert session.notices[-1].bad
    assert session.title == "corridor.log"
    assert session.findings.snapshot is not None


def test_of_two_logs_asked_for_the_newer_one_is_opened(log: MemoryLog) -> None:
    session, _ = session_with(log)
    first, second = ask.OpenLog(Path("a.log")), ask.OpenLog(Path("b.log"))
    session.apply(first)
    session.apply(second)
    session.apply(ask.LogOpened(second, replace(log, name="b.log")))
    session.apply(ask.LogOpened(first, replace(log, name="a.log")))
    assert session.title == "b.log"


def test_opening_another_log_stops_the_work_on_the_first(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    request = ask.OpenLog(Path("next.log"))
    session.apply(ask.Select(Selection("spline", 1)))
    session.apply(request)
    assert session.log is not None
    assert isinstance(session.log, MemoryLog)
    session.apply(ask.LogOpened(request, replace(session.log, content_hash="another")))
    assert inline.cancelled > 0
    assert (session.cursor, session.selection, session.findings.snapshot, session.findings.processed) == (
        0,
        None,
        None,
        0,
    )


def test_choices_change_the_preferences() -> None:
    session = Session(InlineEstimator(), lambda _: None, Preferences())
    session.apply(ask.SetLayer(Layer.TRUTH, True))
    assert session.preferences.layers == FIRST_LAYERS | {Layer.TRUTH}
    session.apply(ask.ToggleLayers(frozenset({Layer.TRUTH, Layer.BEAMS})))
    assert session.preferences.layers == FIRST_LAYERS - {Layer.BEAMS}
    session.apply(ask.SetDark())
    assert not session.view.dark
    session.apply(ask.ChangeSpeed(1))
    assert session.preferences.speed == session.playback.speed == 5.0
    session.apply(ask.FollowRobot(True))
    assert session.preferences.follow_robot


def test_every_change_is_a_new_revision(log: MemoryLog) -> None:
    session, _ = session_with(log)
    for command in (ask.Step(1), ask.SetDark(), ask.Select(Selection("spline", 0)), ask.Play()):
        before = session.revision
        session.apply(command)
        assert session.revision > before


def test_playback_runs_on_with_the_clock(log: MemoryLog) -> None:
    now = [0.0]
    session = Session(InlineEstimator(), lambda _: None, Preferences(speed=2.0), clock=lambda: now[0])
    request = ask.OpenLog(log.path)
    session.apply(request)
    session.apply(ask.LogOpened(request, log))
    session.apply(ask.Play())
    now[0] = 1.0
    session.tick()
    assert session.cursor == 20
    session.apply(ask.SeekTime(0.5))
    assert session.cursor == 5


def test_ten_thousand_steps_take_no_more_memory(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    assert session.log is not None
    rng, actions = np.random.default_rng(5), [a for a in ACTIONS.values() if a.id not in ("run", "optimise", "cancel")]

    def act(count: int) -> int:
        for step in range(count):
            session.apply(ask.Seek(int(rng.integers(len(session.playback.axis)))))
            request = actions[int(rng.integers(len(actions)))].request(session)
            if not isinstance(request, PageRequest):
                session.apply(request)
            assert step % 20 or session.view.scan is not None
            session.notices.clear()
        gc.collect()
        return len(gc.get_objects())

    act(500)
    before = act(500)
    assert act(9000) < before + 2000
    assert not session.troubles
