"""What the panels say, and that their widgets follow the session and ask by commands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.inline import InlineEstimator, deliver, session_with, stand_in
from app.logs import MemoryLog, corridor_log
from bspline_slam.lab.crispness import Crispness
from splinescope import commands as ask
from splinescope.activity import Activity, Work, duration
from splinescope.browser.page import Page
from splinescope.browser.preferences import Preferences
from splinescope.computing.messages import MapChanged
from splinescope.panels import (
    calibration,
    consistency,
    crispness,
    estimate,
    layers,
    log,
    lost,
    observation,
    status,
    timeline,
)
from splinescope.panels.side_bar import SideBar
from splinescope.session import Session
from splinescope.stage import stage_of
from splinescope.typeset import typeset
from splinescope.view import Layer, Selection


@pytest.fixture(scope="module")
def drive() -> MemoryLog:
    return corridor_log(np.random.default_rng(8), 30, notes=("Time steps backwards <3> times.",))


@pytest.fixture
def finished(drive: MemoryLog, monkeypatch: pytest.MonkeyPatch) -> Session:
    stand_in(monkeypatch, drive)
    session, inline = session_with(drive)
    deliver(session, inline)
    return session


@pytest.fixture
def empty() -> Session:
    return Session(InlineEstimator(), lambda _: None, Preferences())


def test_the_status_names_the_log_the_job_and_the_time_left(finished: Session) -> None:
    assert finished.estimation is not None
    finished.estimation.activity = Activity(Work.PROCESSING, 9, "Matching scans", 0.25, 80.0)
    text = "".join(status.headline(finished))
    assert "corridor.log" in text
    assert typeset("25 % · 1 min 20 s left") in text
    assert status.status_line(finished) == "Matching scans · 25 % · 1 min 20 s left"
    finished.estimation.activity = None
    assert (
        f"{len(finished.findings.snapshot.map) if finished.findings.snapshot else 0:,} splines"
        in status.status_line(finished)
    )


def test_the_status_says_up_to_which_scan_a_map_that_grows_is_adjusted(finished: Session) -> None:
    shown = finished.findings.snapshot
    assert finished.estimation is not None
    assert shown is not None
    finished.estimation.activity = Activity(Work.PROCESSING, 7, "Matching scans", 0.5)
    assert "Not adjusted yet" in "".join(status.headline(finished))
    finished.receive(MapChanged(7, shown, 1235))
    assert "Adjusted up to scan 1,234" in "".join(status.headline(finished))
    finished.receive(MapChanged(7, shown))
    assert "Not adjusted yet" in "".join(status.headline(finished))


def test_the_middle_says_what_there_is_instead_of_a_map(finished: Session, empty: Session) -> None:
    assert stage_of(finished) is None
    nothing = stage_of(empty)
    assert nothing is not None and (nothing.kind, nothing.action) == ("empty", "open-sample")
    request = ask.OpenLog(Path("a.log"))
    empty.apply(request)
    loading = stage_of(empty)
    assert loading is not None and (loading.kind, loading.title) == ("loading", "Opening a.log…")
    empty.apply(ask.LogRefused(request, "a.log: is damaged"))
    error = stage_of(empty)
    assert error is not None and (error.kind, error.text) == ("error", "a.log: is damaged")
    finished.findings.log = replace(corridor_log(np.random.default_rng(1), 5), scans=())
    bare = stage_of(finished)
    assert bare is not None and bare.title == "This log holds no scans"


def test_the_status_of_nothing_says_where_to_begin(empty: Session) -> None:
    assert "No log is open" in "".join(status.headline(empty))
    empty.apply(ask.OpenLog(Path("a<b>.log")))
    assert "Opening a&lt;b&gt;.log" in "".join(status.headline(empty))


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(0.4, "0 s"), (59.4, "59 s"), (59.6, "1 min 00 s"), (3599.0, "59 min 59 s"), (7500.0, "2 h 05 min")],
)
def test_lengths_of_time_are_said_in_words(seconds: float, said: str) -> None:
    assert duration(seconds) == said


def test_layers_without_anything_to_show_say_why(finished: Session, drive: MemoryLog) -> None:
    assert not layers.missing(finished)
    finished.findings.covariances = {}
    finished.findings.log = replace(drive, truth=None, odometry=None)
    assert {layer for layer, _ in layers.missing(finished)} == {Layer.TRUTH, Layer.ODOMETRY, Layer.ELLIPSES}


def test_the_log_tells_its_figures_and_its_notes(drive: MemoryLog) -> None:
    rows = dict(log.figures(drive))
    assert rows["scans"] == "30"
    assert rows["beams"] == "181 over 180°, to 12 m"
    assert "Time steps backwards &lt;3&gt; times." in "".join(log.about(drive))
    assert dict(log.figures(replace(drive, odometry=None)))["odometry"].startswith("none")


def test_the_result_of_a_solve_is_told_with_its_figures(finished: Session) -> None:
    text = "".join(estimate.report(finished))
    assert finished.solution is not None
    assert f"{finished.solution.cost_before:,.1f} → {finished.solution.cost_after:,.1f}" in text
    assert typeset("100.0 mm") in text
    assert "900 / 1,000 = 0.90" in text


def test_a_solver_that_cannot_run_yet_says_why(empty: Session) -> None:
    assert "No log is open" in "".join(estimate.report(empty))


def test_a_running_solver_tells_its_cost(finished: Session) -> None:
    assert finished.estimation is not None
    finished.estimation.activity = Activity(Work.OPTIMISING, 9, "Adjustment", 0.5)
    finished.estimation.costs = (1000.0, 12.5)
    assert typeset("Adjustment · 50 % · cost 12.5") in "".join(estimate.report(finished))


def test_the_role_of_a_scan_is_told(finished: Session) -> None:
    assert timeline.role(finished, 0, True, False) == "key scan"
    assert "not in the graph" in timeline.role(finished, 1, False, False)
    assert "lost" in timeline.role(finished, 1, False, True)
    finished.findings.steps.clear()
    assert "not processed" in timeline.role(finished, 0, False, False)
    assert dict(timeline.figures(finished))["beams that hit"].endswith("of 181")


def test_consistency_says_what_there_is_and_what_not(finished: Session, empty: Session) -> None:
    assert "No log is open" in "".join(consistency.introduction(empty))
    assert typeset("95 %") in "".join(consistency.introduction(finished))
    tests = finished.findings.consistency
    assert tests is not None
    finished.findings.consistency = replace(tests, nees=None)
    assert "no ground truth" in "".join(consistency.introduction(finished))
    finished.findings.consistency = None
    assert "has not been tested" in "".join(consistency.introduction(finished))
    assert finished.estimation is not None
    finished.estimation.activity = Activity(Work.PROCESSING, 9, "Matching scans")
    assert "when processing or optimising has ended" in "".join(consistency.introduction(finished))


def test_every_figure_of_a_map_is_shown_or_its_absence_explained(finished: Session, empty: Session) -> None:
    assert crispness.absence(empty) == lost.said(empty, []) == "No log is open."
    assert calibration.UNMEASURED in "".join(calibration.calibration(empty))
    assert lost.said(finished, finished.lost_scans).startswith("No scan was lost")
    finished.findings.steps[3] = replace(finished.findings.steps[3], lost=True)
    assert "1 scan was lost" in lost.said(finished, finished.lost_scans)
    quality = finished.findings.quality
    assert quality is not None
    assert quality.crispness.beams > 300
    unseen = replace(quality, crispness=Crispness.of(np.zeros(0)))
    assert "No beam" in "".join(crispness.crispness(unseen, dark=True))
    seen = replace(quality, crispness=Crispness(1000, 0.0091, 0.95, 0.923))
    shown = "".join(crispness.crispness(seen, dark=True))
    assert typeset("9.1 mm") in shown and typeset("92.3%") in shown
    assert "range noise" in "".join(calibration.calibration(finished))


def test_the_quality_of_each_result_is_kept(finished: Session) -> None:
    first = finished.result
    assert first is not None and first.quality is finished.findings.quality
    finished.findings.forget()
    assert finished.findings.quality is None
    finished.findings.take(first)
    assert finished.findings.quality is first.quality


def test_observations_are_offered_one_after_another(finished: Session) -> None:
    finished.apply(ask.Seek(1))
    key = observation.following_key_scan(finished)
    assert key is not None
    assert key == min(scan for scan, step in finished.findings.steps.items() if step.key and scan > 1)
    finished.apply(ask.Seek(key))
    assert finished.scan_view is not None
    beams = [len(fitted.segment.beams) for fitted in finished.scan_view.segments]
    longest = observation.following_segment(finished.observation, beams)
    assert beams[longest.id] == max(beams)
    seen = set()
    for _ in beams:
        finished.apply(ask.Select(observation.following_segment(finished.observation, beams)))
        assert finished.selection is not None
        seen.add(finished.selection.id)
    assert seen == set(range(len(beams)))


def test_panels_show_every_step_and_the_figures(page: Page, finished: Session) -> None:
    bar = SideBar(page.server.gui, lambda _: None)
    finished.apply(ask.Seek(0))
    finished.apply(ask.Select(Selection("segment", 0)))
    for _ in range(6):
        finished.apply(ask.StepObservation(1))
        bar.refresh(finished)
    shown = "".join(contents(page))
    assert "5. Relation to its spline" in shown
    assert "NIS: " in shown
    assert "key scans against the 95 % band" in shown


def contents(page: Page) -> list[str]:
    """All that HTML widgets of the page hold now."""
    containers = page.server.gui._container_handle_from_uuid.values()
    widgets = [child for container in containers for child in container._children.values()]
    return [str(getattr(widget, "content", "")) for widget in widgets]


def test_widgets_follow_the_session(page: Page, finished: Session, empty: Session) -> None:
    asked: list[object] = []
    bar = SideBar(page.server.gui, asked.append)
    bar.refresh(empty)
    finished.preferences = replace(finished.preferences, layers=frozenset({Layer.TRUTH}), dark=False)
    bar.refresh(finished)
    values = {
        getattr(widget, "label", ""): widget.value for widget in page.server.gui._gui_input_handle_from_uuid.values()
    }
    assert values[Layer.TRUTH.value] is True
    assert values[Layer.BEAMS.value] is False
    assert values["Dark page"] is False
    assert not asked, "what the session changes must not be asked for again"
