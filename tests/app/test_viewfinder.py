"""What is looked at: selected, stepped through, measured, shown again; by hand, by a link or as on the last visit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.inline import InlineEstimator, deliver, session_with
from app.logs import MemoryLog, corridor_log
from bspline_slam.measuring import Measurement, PickedPose
from splinescope import commands as ask
from splinescope.browser.link import Link
from splinescope.browser.preferences import Preferences
from splinescope.session import Session
from splinescope.view import Colouring, Layer, Selection


def test_a_segment_is_selected_only_while_its_scan_is_shown(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    session.apply(ask.Seek(10))
    for kind, stays in (("segment", False), ("spline", True)):
        session.apply(ask.Select(Selection(kind, 0)))
        session.apply(ask.Step(1))
        assert (session.selection is not None) is stays


def test_stepping_opens_the_window_first_and_stops_at_the_ends(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    session.apply(ask.Seek(0))
    session.apply(ask.Select(Selection("segment", 0)))
    session.apply(ask.StepObservation(1))
    assert session.observing
    assert session.observation_step.number == 1
    for _ in range(7):
        session.apply(ask.StepObservation(1))
    assert session.observation_step.number == 5
    session.apply(ask.ShowObservation())
    assert not session.observing


def test_a_log_that_is_opened_again_is_seen_as_it_was_left(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    for command in (
        ask.Seek(7),
        ask.Select(Selection("spline", 1)),
        ask.LookFrom((1.0, 2.0, 0.01)),
        ask.ShowTab("log"),
    ):
        session.apply(command)
    kept, log = session.remembered, session.log
    assert isinstance(log, MemoryLog)
    assert Preferences.from_json(kept.to_json()) == kept
    request = ask.OpenLog(Path("elsewhere.log"))
    for opened in (replace(log, content_hash="another"), log):
        session.apply(request)
        session.apply(ask.LogOpened(request, opened))
        if opened is not log:
            assert (session.place, session.selection, session.tab, session.following) == (None, None, "", True)
    assert (session.cursor, session.place, session.tab) == (7, (1.0, 2.0, 0.01), "log")
    assert session.selection == Selection("spline", 1)
    assert not session.following


def test_a_link_shows_its_moment_standing_still(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    session.apply(ask.Play())
    session.apply(ask.FollowLink(Link(12, frozenset({Layer.GRID}), None, Colouring.AGE, ("smell=3",))))
    assert (session.cursor, session.playback.playing, session.following) == (12, False, False)
    assert session.link == Link(12, frozenset({Layer.GRID}), None, Colouring.AGE)
    assert "smell=3" in session.notices[-1].text


def test_a_link_waits_for_its_log() -> None:
    drive = corridor_log(np.random.default_rng(8), 30)
    opened: list[ask.OpenLog] = []
    session = Session(InlineEstimator(), opened.append, Preferences(), clock=lambda: 0.0)
    session.apply(ask.OpenLog(drive.path))
    session.apply(ask.FollowLink(Link(scan=21)))
    session.apply(ask.LogOpened(opened[0], drive))
    assert session.cursor == 21
    assert not session.following


def test_the_ruler_measures_between_two_picked_things(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    assert session.map_view is not None
    keys = session.map_view.key_scans
    session.apply(ask.Select(Selection("key pose", keys[0])))
    session.apply(ask.Measure())
    session.apply(ask.Select(Selection("key pose", keys[3])))
    session.apply(ask.Measure())
    assert session.ruler is not None and session.ruler.found is None
    deliver(session, inline)
    found, shown = session.ruler.found, session.findings.snapshot
    assert isinstance(found, Measurement) and shown is not None
    gap = float(np.linalg.norm(shown.poses[keys[3], :2] - shown.poses[keys[0], :2]))
    assert found.distance == pytest.approx(gap)
    assert session.view.measured == pytest.approx(shown.poses[[keys[0], keys[3]], :2])
    session.apply(ask.LayRuler(PickedPose(keys[1])))
    assert session.ruler.picked == (PickedPose(keys[1]),)
    session.apply(ask.Leave())
    assert session.ruler is None and session.selection is not None
    session.apply(ask.Leave())
    assert session.selection is None


def test_the_ruler_says_what_it_cannot_measure(log: MemoryLog, finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    for picked in (PickedPose(0), PickedPose(1)):  # scan 1 is not a key scan
        session.apply(ask.LayRuler(picked))
    deliver(session, inline)
    assert session.ruler is not None
    assert session.ruler.found == "Scan 1 is not a key scan of what was solved."
    waiting, _ = session_with(log)
    for picked in (PickedPose(0), PickedPose(5)):
        waiting.apply(ask.LayRuler(picked))
    assert waiting.ruler is not None and isinstance(waiting.ruler.found, str)


def test_iterations_of_the_solve_are_shown_again(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    session.apply(ask.Seek(5))
    result = session.view
    assert len(session.frames) == 11 and session.frame is None
    session.apply(ask.ShowIteration(0))
    first = session.view
    assert first.map is not None and result.map is not None and first.scan is not None and result.scan is not None
    moved = np.array([0.1 * (1 - 0.5**10), 0.0])
    assert first.map.key_poses[:, :2] == pytest.approx(result.map.key_poses[:, :2] - moved, abs=1e-3)
    for before, after in zip(first.map.map, result.map.map, strict=True):
        assert before.curve.control_points == pytest.approx(after.curve.control_points - moved, abs=1e-3)
    assert first.scan.pose[:2] == pytest.approx(result.scan.pose[:2] - moved, abs=1e-3)
    assert session.view.map is first.map
    for _ in range(20):
        session.apply(ask.StepIteration(1))
    assert session.frame is None and session.view.map is result.map
    session.apply(ask.StepIteration(-1))
    assert session.frame == 9
    session.apply(ask.RunAgain())
    assert session.frame is None
