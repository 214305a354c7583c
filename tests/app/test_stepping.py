"""A sample log in the browser: its consistency drawn, and one observation stepped through from beams to relation."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import expect

from app.chromium import Window, until
from app.running import COMPILING, running_viewer
from splinescope import commands as ask
from splinescope.observation_view import ObservationStep
from splinescope.paths import find_log
from splinescope.viewer import Viewer

Opener = Callable[..., Window]


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    """The application with the smallest sample, processed and tested."""
    with running_viewer(find_log("three_splines"), tmp_path_factory.mktemp("memory") / "session.json") as viewer:
        until(lambda: viewer.session.findings.consistency, "the tests of consistency", COMPILING)
        yield viewer


def test_an_observation_is_stepped_through(viewer: Viewer, open_window: Opener) -> None:
    viewer.post(ask.Seek(8))
    viewer.post(ask.Select(None))
    window = open_window(viewer.url)
    page = window.page
    page.keyboard.press("s")
    page.get_by_role("button", name="Take the longest segment").click()
    expect(page.get_by_text("1. Points and chord-length parameters")).to_be_visible()
    picture = page.get_by_role("img", name="Beam ends along the segment")
    expect(picture).to_be_visible()
    for step in list(ObservationStep)[1:3]:
        page.get_by_role("button", name="Next →").click()
        expect(page.get_by_text(f"{step.number}. {step.value}")).to_be_visible()
    for step in list(ObservationStep)[3:]:
        page.keyboard.press("n")
        expect(page.get_by_text(f"{step.number}. {step.value}")).to_be_visible()
    expect(page.get_by_text("Relation: ")).to_be_visible()
    window.screenshot("observation")
    page.keyboard.press("b")
    expect(page.get_by_role("img", name="Ellipses of the three terms")).to_be_visible()
    expect(page.get_by_text("Step 4 of 5")).to_be_visible()
    page.get_by_role("button", name="Close").click()
    expect(page.get_by_text("Step 4 of 5")).to_be_hidden()


def test_consistency_is_drawn_and_leads_to_its_worst_scan(viewer: Viewer, open_window: Opener) -> None:
    tests = viewer.session.findings.consistency
    assert tests is not None
    assert tests.nees is not None
    viewer.post(ask.Select(None))
    window = open_window(viewer.url)
    window.page.get_by_role("tab", name="Quality", exact=True).click()
    window.page.get_by_text("Consistency", exact=True).click()
    plot = window.page.get_by_role("img", name="NEES of key scans against the 95 % band")
    expect(plot).to_be_visible()
    assert plot.locator("circle").count() > 10
    window.page.get_by_role("button", name="Worst scan").first.click()
    until(lambda: tests.nees and viewer.session.cursor == tests.nees.worst, "the worst scan")
    window.screenshot("consistency")
