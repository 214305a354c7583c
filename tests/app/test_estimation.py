"""The estimator's work and its results, with an estimator that answers at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.inline import InlineEstimator, deliver, session_with
from app.logs import MemoryLog
from bspline_slam import se2
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.spline_map import SplineMap
from splinescope import commands as ask
from splinescope.activity import Work
from splinescope.computing import messages as told
from splinescope.computing.edit_messages import Ghost
from splinescope.recipe import Recipe
from splinescope.result import KEPT
from splinescope.session import Session


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


def test_what_is_measured_of_a_result_is_not_shown_of_what_it_nearly_becomes(
    finished: tuple[Session, InlineEstimator],
) -> None:
    session, _ = finished
    estimation, result = session.estimation, session.result
    assert estimation is not None
    assert result is not None
    quality = result.quality
    assert quality is not None
    estimation.amend(replace(result, quality=None, measured=False))
    assert estimation.activity is not None
    measuring = estimation.activity.job
    another = LoopClosure(0, 7, se2.IDENTITY, np.eye(3), 1.0, 1.0, accepted=True, reason="")
    estimation.glimpse(Ghost(None, SplineMap(), closures=(*result.snapshot.loop_closures, another)))
    assert estimation.activity is None, "it would be void"
    session.receive(told.QualityFound(measuring, quality))
    assert session.findings.quality is None
    estimation.compare(None)
    assert estimation.activity is not None
    session.receive(told.QualityFound(estimation.activity.job, quality))
    assert session.findings.quality is None
    assert session.result is not None
    assert session.result.quality is quality


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
