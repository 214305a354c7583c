"""The workbench from Python: it steps, solves and listens, and the page follows."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from app.chromium import Window
from app.logs import corridor_log, write_carmen
from app.running import COMPILING
from bspline_slam.edits.edit import Force
from bspline_slam.errors import ConfigError, EditError, SplineSlamError
from splinescope import commands as ask
from splinescope.api import Workbench, open_workbench
from splinescope.view import Selection


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_carmen(corridor_log(np.random.default_rng(6), 40), tmp_path_factory.mktemp("logs") / "corridor.log")


@pytest.fixture(scope="module")
def scope(log: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workbench]:
    with open_workbench(log, browser=False, session=tmp_path_factory.mktemp("memory") / "session.json") as scope:
        scope.wait(COMPILING)
        yield scope


def test_a_program_steps_and_the_page_follows(scope: Workbench, open_window: Callable[..., Window]) -> None:
    window = open_window(scope.url)
    scope.seek(7)
    scope.step()
    assert scope.cursor == 8
    expect(window.page.get_by_label("Jump to scan")).to_have_value("8")
    window.page.keyboard.press("Home")
    expect(window.page.get_by_label("Jump to scan")).to_have_value("0")
    scope.step(3)
    assert scope.cursor == 3


def test_what_people_select_is_told(scope: Workbench, open_window: Callable[..., Window]) -> None:
    told: queue.SimpleQueue[Selection | None] = queue.SimpleQueue()
    scope.on_selection(told.put)
    scope.select(Selection("spline", 0))
    assert told.get(timeout=COMPILING) == Selection("spline", 0)
    window = open_window(scope.url)
    window.page.keyboard.press("Escape")
    assert told.get(timeout=COMPILING) is None
    scope.seek(0)
    window.page.keyboard.press("j")
    assert told.get(timeout=COMPILING) == Selection("segment", 0) == scope.selection


def test_a_program_solves_the_map_and_reads_it(scope: Workbench) -> None:
    solution = scope.solve(COMPILING)
    assert solution.cost_after <= solution.cost_before
    assert scope.poses.shape == (40, 3)
    assert len(scope.map) > 3
    scope.do(ask.DeleteResult(1))
    assert scope.url in scope._repr_html_()


def test_a_program_overrules_the_estimator_and_takes_it_back(scope: Workbench) -> None:
    told: queue.SimpleQueue[object] = queue.SimpleQueue()
    scope.on_edits(told.put)
    scope.wait(COMPILING)
    steps = scope.session.findings.steps.values()
    seen = next(a for step in steps for a in step.associations if a.spline is not None)
    other = next(spline.id for spline in scope.map if spline.id != seen.spline)
    scope.force(seen.scan, seen.segment, other)
    assert told.get(timeout=COMPILING) == scope.edits
    assert [edit.spline for edit in scope.edits if isinstance(edit, Force)] == [other] * len(scope.edits)
    scope.wait(COMPILING)
    scope.undo()
    assert told.get(timeout=COMPILING) == () == scope.edits
    with pytest.raises(EditError, match="no segment 99"):
        scope.force(seen.scan, 99, other)
    scope.wait(COMPILING)


def test_a_session_refers_to_its_log_and_tells_what_became_of_it(
    log: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    session, copy = tmp_path / "session.json", tmp_path / "copy.log"
    copy.write_bytes(log.read_bytes())
    with open_workbench(copy, browser=False, session=session):
        pass
    moved = copy.rename(tmp_path / "moved.log")
    with pytest.raises(ConfigError, match=r"copy\.log, which is gone"):
        open_workbench(browser=False, session=session)
    with open_workbench(moved, browser=False, session=session):
        assert "The log has moved: It was" in caplog.text
    moved.write_bytes(b"".join(moved.read_bytes().splitlines(keepends=True)[:-5]))
    caplog.clear()
    with open_workbench(browser=False, session=session) as scope:
        assert scope.session.log is not None and scope.session.log.path == moved
        assert "The log has changed: moved.log is not what it was" in caplog.text


@pytest.mark.parametrize("log", [None, "office"])
def test_a_file_that_is_no_session_stays_as_it_is(log: str | None, tmp_path: Path) -> None:
    other = tmp_path / "thesis.txt"
    other.write_text("Chapter 1", encoding="utf-8")
    with pytest.raises(ConfigError, match="no session of SplineScope"):
        open_workbench(log, browser=False, session=other)
    assert other.read_text(encoding="utf-8") == "Chapter 1"


def test_what_cannot_be_done_is_raised_in_a_sentence(scope: Workbench, log: Path, tmp_path: Path) -> None:
    with pytest.raises(SplineSlamError, match="nowhere"):
        scope.open(tmp_path / "nowhere.log")
    bad = tmp_path / "bad.log"
    bad.write_bytes(bytes(range(256)) * 4)
    with pytest.raises(SplineSlamError):
        scope.open(bad)
    scope.open(log)
    with pytest.raises(ConfigError, match="still being processed"):
        scope.solve()
    with pytest.raises(TimeoutError):
        scope.wait(0.001)
    scope.wait(COMPILING)
