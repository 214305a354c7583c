"""The guided tour, walked by somebody who has never been here."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from app.chromium import Window, until
from app.running import COMPILING
from splinescope.api import open_workbench
from splinescope.mistake import mistake_in
from splinescope.tour import STEPS, erring


def test_the_tour_makes_a_mistake_and_lets_it_be_mended(
    open_window: Callable[..., Window], tmp_path_factory: pytest.TempPathFactory
) -> None:
    with open_workbench("office", browser=False, session=tmp_path_factory.mktemp("memory") / "session.json") as scope:
        session, window = scope.session, open_window(scope.url)
        card, page = window.page.get_by_role("region", name="Guided tour"), window.page
        card.get_by_role("button", name="Take the tour").click()
        expect(card).to_contain_text("the tour goes on as soon as that is done")
        expect(card).to_contain_text(STEPS[0].text, timeout=1000 * COMPILING)
        mistake = mistake_in(session.findings)
        assert mistake is not None
        before = scope.poses
        card.get_by_role("button", name="Next").click()
        expect(card).to_contain_text(STEPS[1].title)
        until(lambda: session.cursor == mistake.scan - 4, "the place of the second step")
        for _ in range(4):
            page.keyboard.press("ArrowRight")
        expect(card).to_contain_text(STEPS[2].title)
        card.get_by_role("button", name="Next").click()
        until(lambda: erring(session, mistake) and not session.editing.making, "the mistake", COMPILING)
        until(lambda: session.editing.explanation, "what the solver says", COMPILING)
        assert abs(scope.poses - before).max() > 0.0
        told = session.editing.explanation
        assert told is not None
        assert told.beams[0] == told.beams[1]
        assert sum(told.after.values()) > sum(told.before.values()) + 10.0  # nobody wonders at a cost that falls
        card.get_by_role("button", name="Next").click()
        expect(card).to_contain_text(STEPS[4].title)
        until(
            lambda: session.editing.doubts.queue[:1] and "by hand" in session.editing.doubts.queue[0].sentence, "doubt"
        )
        whole = window.fit()["metresPerPixel"]
        expect(page.locator("[data-row=doubt]").first).to_be_in_viewport()
        page.keyboard.press("q")
        expect(card).to_contain_text(STEPS[5].title)
        until(lambda: window.viewport()["metresPerPixel"] < 0.7 * whole, "a nearer look at the mistake")
        window.screenshot("tour")
        page.keyboard.press("Control+z")
        expect(card).to_contain_text(STEPS[6].title)
        card.get_by_role("button", name="Finish").click()
        expect(card).to_be_hidden()
        until(lambda: not session.editing.making, "the map as it was", COMPILING)
        assert session.editing.history.active == ()
        assert (scope.poses == before).all()
        assert session.preferences.toured
