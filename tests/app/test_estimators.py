"""Every estimator, asked for from the page on three splines, and by the worker's jobs on an office."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from app.chromium import Window, until
from app.logs import file_of
from app.running import COMPILING, running_viewer, settled
from bspline_slam.backends import BACK_ENDS
from bspline_slam.logs import open_log
from splinescope.comparison import largest_pose_difference
from splinescope.computing.jobs import Jobs
from splinescope.computing.messages import (
    CovariancesFound,
    Failed,
    FindCovariances,
    Finished,
    Message,
    ProcessLog,
    SolveMap,
)
from splinescope.computing.packed_result import PackedResult
from splinescope.recipe import Recipe
from splinescope.result import Result
from splinescope.viewer import Viewer

SAMPLES = Path(__file__).parents[2] / "sample_logs"
OFFICE_SCANS = 40

Opener = Callable[..., Window]


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    """The application with three splines, processed."""
    with running_viewer(SAMPLES / "three_splines.log.gz", tmp_path_factory.mktemp("memory") / "session.json") as viewer:
        session = viewer.session
        ended = "the end of processing"
        settled(viewer, lambda: session.result is not None and session.activity is None, ended, COMPILING)
        yield viewer


def tab(window: Window, name: str) -> None:
    window.page.get_by_role("tab", name=name, exact=True).click()


def choose(window: Window, label: str, option: str) -> None:
    """Choose from the drop-down list in the row of that label."""
    row = "ancestor::div[contains(@class, 'mantine-Flex-root')][1]"
    window.page.get_by_text(label, exact=True).locator(f"xpath={row}").get_by_role("combobox").click()
    window.page.get_by_role("option", name=option, exact=True).click()


def drawn(window: Window) -> bool:
    """Whether the compared result is in sight."""
    node = window.node("/splinescope/compared")
    return node is not None and node["visible"]


def press(window: Window, viewer: Viewer, button: str) -> Result:
    """Press a button that starts a job; the result it brings, once the estimator is idle."""
    session, before = viewer.session, viewer.session.results.made
    window.page.get_by_role("button", name=button).click()
    settled(viewer, lambda: session.results.made > before and session.activity is None, "a result", COMPILING)
    assert session.troubles == ()
    assert session.result is not None
    return session.result


def test_every_estimator_solves_the_map_from_the_page(running: Viewer, open_window: Opener) -> None:
    window = open_window(running.url)
    tab(window, "Estimate")
    for back_end in BACK_ENDS:
        choose(window, "Estimator", back_end)
        until(lambda name=back_end: running.session.recipe.back_end == name, "the choice")
        result = press(window, running, "Only solve this map again")
        assert result.recipe == Recipe(back_end=back_end)
        assert result.solution is not None
        assert result.solution.ate is not None
        assert result.solution.ate.rms < 0.05
        assert result.anees is not None


def test_another_model_is_run_over_the_log_and_compared(running: Viewer, open_window: Opener) -> None:
    window, session = open_window(running.url), running.session
    tab(window, "Estimate")
    choose(window, "Estimator", "direct")
    choose(window, "Model", "chord-length")
    expect(window.page.get_by_text("Another model, order")).to_be_visible()
    expect(window.page.get_by_role("button", name="Only solve this map again")).to_be_disabled()
    other = session.result
    result = press(window, running, "Run the whole log again")
    assert result.recipe == Recipe(model="chord-length")
    tab(window, "Compare")
    until(lambda: drawn(window), "the compared result")
    assert session.compared is other
    assert other is not None
    most = largest_pose_difference(result, other)
    assert most is not None
    expect(window.page.get_by_text(f"Largest pose difference: {1000 * most.distance:.1f} mm")).to_be_visible()
    for quantity in ("ATE, RMS", "pose NEES / 3", "χ² / dof", "time", "control points"):
        expect(window.page.get_by_role("cell", name=quantity, exact=True)).to_be_visible()
    window.screenshot("compare")
    window.page.get_by_role("button", name="Largest difference").click()
    until(lambda: session.cursor == most.scan, "the scan that differs most")
    window.page.get_by_role("button", name="Swap the two").click()
    until(lambda: session.result is other and session.compared is result, "the two swapped")
    window.page.keyboard.press("0")
    until(lambda: not drawn(window), "the layer switched off")
    window.page.keyboard.press("0")
    window.page.get_by_role("button", name="Delete it").click()
    until(lambda: session.compared is None, "the compared result to go")


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The beginning of the office, as long as the slowest estimator has the patience for."""
    lines = gzip.decompress((SAMPLES / "office.log.gz").read_bytes()).decode().splitlines(keepends=True)
    scans = [number for number, line in enumerate(lines) if line.startswith("FLASER")]
    path = tmp_path_factory.mktemp("logs") / "office.log"
    path.write_text("".join(lines[: scans[OFFICE_SCANS]]), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def processed(office: Path) -> tuple[Jobs, list[Message], bytes]:
    """Jobs that have processed it, what they send, and the map."""
    sent: list[Message] = []
    jobs = Jobs(sent.append)
    jobs.do(ProcessLog(1, file_of(open_log(office)), Recipe().config()), lambda: False)
    assert isinstance(sent[-1], Finished)
    assert sent[-1].kept is not None
    return jobs, sent, sent[-1].kept


@pytest.mark.parametrize("back_end", BACK_ENDS)
def test_every_estimator_solves_an_office(
    processed: tuple[Jobs, list[Message], bytes], office: Path, back_end: str
) -> None:
    jobs, sent, kept = processed
    file, config = file_of(open_log(office)), Recipe(back_end=back_end).config()
    sent.clear()
    jobs.do(SolveMap(2, file, PackedResult(kept, config)), lambda: False)
    done = sent[-1]
    assert isinstance(done, Finished), [m.sentence for m in sent if isinstance(m, Failed)]
    assert done.kept is not None
    assert done.solution is not None
    assert done.snapshot is not None
    assert done.solution.back_end == back_end
    assert done.solution.largest_move < 0.1
    jobs.do(FindCovariances(3, file, PackedResult(done.kept, config)), lambda: False)
    found = next(message for message in sent if isinstance(message, CovariancesFound))
    assert set() != found.splines.keys() <= {spline.id for spline in done.snapshot.map}
