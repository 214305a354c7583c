"""The session: commands and messages in, what the page shows out."""

from __future__ import annotations

import gc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.inline import InlineEstimator, deliver, session_with, stand_in
from app.logs import MemoryLog, corridor_log
from bspline_slam import se2
from bspline_slam.measuring import Measurement, PickedPose
from splinescope import commands as ask
from splinescope.actions import ACTIONS, PageRequest
from splinescope.activity import Work
from splinescope.browser.link import Link
from splinescope.browser.preferences import FIRST_LAYERS, Preferences
from splinescope.computing import messages as told
from splinescope.recipe import Recipe
from splinescope.result import KEPT
from splinescope.session import Session
from splinescope.view import Colouring, Layer, Selection


@pytest.fixture(scope="module")
def drive() -> MemoryLog:
    return corridor_log(np.random.default_rng(2))


@pytest.fixture
def log(drive: MemoryLog, monkeypatch: pytest.MonkeyPatch) -> MemoryLog:
    stand_in(monkeypatch, drive)
    return drive


@pytest.fixture
def finished(log: MemoryLog) -> tuple[Session, InlineEstimator]:
    session, inline = session_with(log)
    deliver(session, inline)
    return session, inline


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


def test_a_finished_log_has_map_solution_and_covariances(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    view = session.map_view
    assert view is not None
    assert session.activity is None
    assert len(view.map) > 0
    assert view.covariances.keys() == {spline.id for spline in view.map}
    assert view.odometry is not None
    assert np.allclose(view.odometry[0], view.estimate[0])
    assert session.solution is not None
    assert session.solution.cost_after < session.solution.cost_before
    assert session.solution.largest_move == pytest.approx(0.1)
    assert [notice.bad for notice in session.notices] == [False]


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


def test_the_map_moves_with_every_iteration(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    session.apply(ask.Seek(7))
    start = session.findings.snapshot
    assert start is not None
    session.apply(ask.Optimise())
    first = next(message for message in inline.messages if isinstance(message, told.Iterated))
    aside = np.array([1.0, 0.0, 0.0])
    record = replace(first.record, poses=start.poses[start.key_scans] + aside)
    session.receive(replace(first, record=record))
    assert session.findings.snapshot is not None
    assert np.allclose(session.findings.snapshot.poses, start.poses + aside)
    assert session.scan_view is not None
    assert np.allclose(session.scan_view.pose, session.findings.snapshot.poses[7])
    assert session.costs == (record.cost,)


def test_a_failed_or_stopped_solve_leaves_the_map_as_it_was(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    before = session.findings.snapshot
    for end in (told.Failed(0, "no memory left"), told.Stopped(0)):
        session.apply(ask.Optimise())
        job = len(inline.asked)
        session.receive(next(message for message in inline.messages if isinstance(message, told.Iterated)))
        inline.messages.clear()
        session.receive(replace(end, job=job))
        assert session.findings.snapshot is before
        assert session.activity is None
    assert session.troubles == ("no memory left",)


def test_nothing_is_lost_when_the_estimator_dies_in_the_middle(log: MemoryLog) -> None:
    session, inline = session_with(log)
    while session.findings.snapshot is None:
        session.receive(inline.messages.pop(0))
    session.receive(told.Failed(1, "The estimator ended unexpectedly."))
    assert session.findings.snapshot is not None
    assert session.activity is None
    assert session.notices[-1].bad
    session.apply(ask.Optimise())
    assert "Run the whole log again" in session.notices[-1].text


def test_messages_of_a_job_that_nobody_waits_for_are_dropped(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    before = session.findings.snapshot
    session.receive(told.Finished(1, None))
    session.receive(told.Failed(1, "too late"))
    assert session.findings.snapshot is before
    assert not session.troubles


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


def test_a_segment_is_selected_only_while_its_scan_is_shown(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    session.apply(ask.Seek(10))
    for kind, stays in (("segment", False), ("spline", True)):
        session.apply(ask.Select(Selection(kind, 0)))
        session.apply(ask.Step(1))
        assert (session.selection is not None) is stays


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


def solved_again(session: Session, inline: InlineEstimator, back_end: str = "sam") -> None:
    session.apply(ask.Choose(Recipe(back_end=back_end)))
    session.apply(ask.Optimise())
    deliver(session, inline)


def numbers(session: Session) -> tuple[list[int], int | None, int | None]:
    results = session.results
    return (
        [result.number for result in results.all],
        results.shown.number if results.shown is not None else None,
        results.compared.number if results.compared is not None else None,
    )


def test_a_solve_with_another_estimator_is_kept_beside_the_first_result(
    finished: tuple[Session, InlineEstimator],
) -> None:
    session, inline = finished
    first = session.result
    solved_again(session, inline)
    assert numbers(session) == ([1, 2], 2, 1)
    assert session.result is not None
    assert session.results.run_behind(session.result).number == 1
    assert session.result.recipe.back_end == "sam"
    assert session.result.measured
    assert session.view.compared is session.compared_view
    assert first is not None
    assert session.compared_view is not None
    assert session.compared_view.map is first.snapshot.map


def test_every_estimator_starts_from_the_run_over_the_log(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    run = session.result
    assert run is not None
    for back_end in ("pose_graph", "sam"):
        solved_again(session, inline, back_end)
        asked = next(request for request in reversed(inline.asked) if isinstance(request, told.SolveMap))
        assert asked.result.kept is run.kept
        assert session.result is not None
        assert session.results.run_behind(session.result).number == run.number
    session.apply(ask.DeleteResult(run.number))
    solved_again(session, inline)
    assert session.results.run_behind(session.result).number == run.number, (
        "what others were made from is not forgotten with it"
    )


def test_the_earlier_result_comes_back_as_it_was(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    before, solution, asked = session.map_view, session.solution, len(inline.asked)
    assert before is not None
    solved_again(session, inline)
    session.apply(ask.ShowResult(1))
    deliver(session, inline)
    assert numbers(session) == ([1, 2], 1, 2)
    assert session.map_view is not None
    assert session.map_view.map is before.map
    assert session.map_view.covariances is before.covariances
    assert session.solution is solution
    assert len(inline.asked) == asked + 2, "one solve and its covariances, and nothing for going back"


def test_a_run_with_another_model_processes_the_log_again_and_cannot_be_had_by_solving(
    finished: tuple[Session, InlineEstimator],
) -> None:
    session, inline = finished
    recipe = Recipe(model="chord-length", order=3)
    session.apply(ask.Choose(recipe))
    session.apply(ask.Optimise())
    assert "run the whole log again" in session.notices[-1].text
    session.apply(ask.RunAgain())
    asked = inline.asked[-1]
    assert isinstance(asked, told.ProcessLog)
    assert asked.config == recipe.config()
    assert session.findings.processed == 0
    assert session.compared is session.result, "what was there stays in sight while the new map grows"
    deliver(session, inline)
    assert numbers(session) == ([1, 2], 2, 1)
    assert session.result is not None
    assert session.result.recipe == recipe
    assert session.result.origin is None


def test_a_run_that_is_impossible_is_refused_with_its_numbers(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    asked = len(inline.asked)
    session.apply(ask.Choose(Recipe(model="chord-length", order=4, control_points=3)))
    session.apply(ask.RunAgain())
    assert "at least 4 control points, not 3" in session.notices[-1].text
    assert len(inline.asked) == asked


def test_a_run_that_fails_leaves_the_result_shown_before(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    shown, steps = session.result, dict(session.findings.steps)
    session.apply(ask.RunAgain())
    session.receive(next(message for message in inline.messages if isinstance(message, told.MapChanged)))
    session.receive(told.Failed(len(inline.asked), "no memory left"))
    assert shown is not None
    assert session.findings.snapshot is shown.snapshot
    assert session.findings.steps == steps
    assert numbers(session) == ([1], 1, None)


def test_a_run_that_is_cancelled_is_kept_beside_the_result_shown_before(
    finished: tuple[Session, InlineEstimator],
) -> None:
    session, inline = finished
    shown = session.result
    session.apply(ask.RunAgain())
    part = next(message for message in inline.messages if isinstance(message, told.MapChanged)).snapshot
    inline.messages.clear()
    session.receive(told.Stopped(len(inline.asked), part, b"part"))
    assert numbers(session) == ([1, 2], 1, None)
    assert shown is not None
    assert session.findings.snapshot is shown.snapshot
    assert session.results.all[1].stopped_after == len(part.poses)
    assert "kept as result 2" in session.notices[-1].text


def test_the_result_shown_cannot_be_deleted_and_any_other_can(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    solved_again(session, inline)
    session.apply(ask.DeleteResult(2))
    assert "stays" in session.notices[-1].text
    session.apply(ask.DeleteResult(1))
    assert numbers(session) == ([2], 2, None)
    session.apply(ask.DeleteResult(1))
    assert "no such result" in session.notices[-1].text
    solved_again(session, inline)
    session.apply(ask.ShowResult(2))
    session.apply(ask.DeleteResult(3))
    solved_again(session, inline)
    assert numbers(session) == ([2, 4], 4, 2), "a number is never used twice"


def test_covariances_that_were_cancelled_are_computed_when_asked_for_again(
    finished: tuple[Session, InlineEstimator],
) -> None:
    session, inline = finished
    session.apply(ask.Optimise())
    while not (session.activity is not None and session.activity.work is Work.COVARIANCES):
        session.receive(inline.messages.pop(0))
    session.apply(ask.Cancel())
    assert inline.cancelled == len(inline.asked)
    inline.messages.clear()
    session.receive(told.Stopped(len(inline.asked)))
    assert session.activity is None
    assert numbers(session) == ([1, 2], 2, 1)
    assert not session.findings.covariances
    session.apply(ask.ShowResult(2))
    deliver(session, inline)
    assert session.findings.covariances


def test_results_belong_to_their_log(finished: tuple[Session, InlineEstimator]) -> None:
    session, inline = finished
    solved_again(session, inline)
    assert session.log is not None
    request = ask.OpenLog(Path("next.log"))
    session.apply(request)
    session.apply(ask.LogOpened(request, session.log))
    assert numbers(session) == ([], None, None)
    assert session.compared_view is None
    assert session.recipe.back_end == "sam", "what was chosen stays for the next log"
    assert session.notices[-1].title == "Your choices stay"


def test_the_oldest_result_falls_out_and_that_is_said(finished: tuple[Session, InlineEstimator]) -> None:
    session, _ = finished
    assert session.estimation is not None and session.result is not None
    first = session.result
    for number in range(2, KEPT + 1):
        session.estimation._add(replace(first, number=number))
    assert [result.number for result in session.results.all] == list(range(1, KEPT + 1))
    session.apply(ask.CompareWith(1))
    session.estimation._add(replace(first, number=KEPT + 1), show=False)
    assert numbers(session) == ([1, *range(3, KEPT + 2)], KEPT, 1), "what is looked at stays"
    assert session.notices[-1].title == "Result 2 has left the list"


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
