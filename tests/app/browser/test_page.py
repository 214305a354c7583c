"""A page: clicks and rows arrive, what is sent is shown, and what makes no sense is not passed on."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from app.chromium import ROOM, Opener, until
from splinescope import table
from splinescope.actions import described
from splinescope.browser.page import Page, open_page


def test_a_lost_connection_is_told(open_window: Opener) -> None:
    page = open_page("127.0.0.1", 0)
    page.send("actions", described())
    try:
        window = open_window(page.url)
        expect(window.page.get_by_role("alert")).to_be_hidden()
    finally:
        page.stop()
    expect(window.page.get_by_role("alert")).to_contain_text("The connection is lost")
    window.errors.clear()


def test_what_one_page_is_asked_to_do_no_later_page_does(page: Page, open_window: Opener) -> None:
    first = open_window(page.url)
    until(lambda: page.server.get_clients(), "the page to be known")
    page.perform("help")
    expect(first.page.get_by_role("dialog", name="Keys and help")).to_be_visible()
    later = open_window(page.url)
    assert not later.page.evaluate("splinescope.latest.has('perform')")


def test_a_click_gives_the_point_of_the_world(page: Page, open_window: Opener) -> None:
    clicks: list[tuple[np.ndarray, float, int]] = []
    page.on_click(lambda point, scale, client: clicks.append((point, scale, client.client_id)))
    page.fit(ROOM)
    window = open_window(page.url)
    window.page.mouse.click(*window.pixel_of(2.0, 1.5))
    until(lambda: clicks, "the click")
    point, scale, client = clicks[0]
    view = window.viewport()
    assert point == pytest.approx([2.0, 1.5], abs=2 * scale)
    assert scale == pytest.approx(view["metresPerPixel"])
    assert client in page.server.get_clients()
    window.page.mouse.move(400, 300)
    window.page.mouse.down()
    window.page.mouse.move(500, 300, steps=3)
    window.page.mouse.up()
    window.page.mouse.click(*window.pixel_of(0.0, 0.0))
    until(lambda: len(clicks) > 1, "the second click")
    assert clicks[1][0] == pytest.approx([0.0, 0.0], abs=2 * scale)  # the drag between them was none


def test_a_row_of_a_table_tells_its_name_and_number(page: Page, open_window: Opener) -> None:
    told: list[tuple[str, int]] = []
    page.on_row(lambda name, number: told.append((name, number)))
    rows = [(7, ("3 – 90", "0.71"), ""), (8, ("4 – 95", "0.31"), "Too low.")]
    page.server.gui.add_html(table.block(table.leading("closure", ("Scans", "Score"), rows)))
    window = open_window(page.url)
    window.page.get_by_text("0.71").click()
    window.page.get_by_text("Too low.").click()
    window.page.get_by_role("button", name="3 – 90").focus()
    window.page.keyboard.press("Enter")
    until(lambda: len(told) == 3, "three rows")
    assert told == [("closure", 7), ("closure", 8), ("closure", 7)]


def test_the_page_can_be_light(page: Page, open_window: Opener) -> None:
    window = open_window(page.url)
    dark = window.page.evaluate("getComputedStyle(document.querySelector('.scope-sheet')).backgroundColor")
    page.set_dark(False)
    window.page.wait_for_function("document.documentElement.classList.contains('scope-light')")
    light = window.page.evaluate("getComputedStyle(document.querySelector('.scope-sheet')).backgroundColor")
    assert sum(map(int, light[4:-1].split(","))) > sum(map(int, dark[4:-1].split(",")))


def test_the_legend_folds_and_remembers_it(page: Page, open_window: Opener) -> None:
    entries = [{"label": "Matched", "svg": "<svg viewBox='0 0 34 14'></svg>"}]
    page.send("legend", [{"title": "Associations", "entries": entries}])
    window = open_window(page.url)
    entry = window.page.get_by_text("Matched")
    assert not entry.is_visible()
    window.page.get_by_text("Legend").click()
    entry.wait_for(state="visible")
    window.page.reload()
    entry.wait_for(state="visible")


def test_nonsense_from_a_page_is_not_passed_on(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    window = open_window(page.url)
    for topic, value in (("timeline", "{}"), ("click", "7"), ("action", "not json"), ("?", "1"), ("action", '"x"')):
        message = {"type": "PageEvent", "topic": topic, "value": value}
        window.page.evaluate("message => __viserMutable.sendMessage(message)", message)
    until(lambda: asked, "the action that made sense")
    assert asked == ["x"]
