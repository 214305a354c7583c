"""Tabs are opened by Python and by persons."""

from __future__ import annotations

from playwright.sync_api import expect

from app.chromium import Opener, until
from splinescope.actions.page import TABS
from splinescope.browser.page import Page, TimelineState


def with_tabs(page: Page, names: tuple[str, ...] = TABS) -> None:
    tabs = page.server.gui.add_tab_group()
    for name in names:
        with tabs.add_tab(name):
            page.server.gui.add_html(f"under {name}")


def test_keys_that_are_the_scripts_own_need_no_python(page: Page, open_window: Opener) -> None:
    page.timeline(TimelineState(index=30, length=101, processed=60))
    window = open_window(page.url)
    window.page.keyboard.press("g")
    expect(window.page.get_by_label("Jump to scan")).to_be_focused()
    window.page.keyboard.press("Escape")
    with_tabs(page, ("Layers", "Scan"))
    expect(window.page.get_by_text("under Layers")).to_be_visible()
    until(lambda: page.server.get_clients(), "the page to be known")
    page.perform("tab-scan")
    expect(window.page.get_by_text("under Scan")).to_be_visible()


def test_the_tab_of_the_last_visit_is_opened_also_when_tabs_come_late(page: Page, open_window: Opener) -> None:
    told: list[str] = []
    page.on_tab(told.append)
    page.send("tab", "edit")
    window = open_window(page.url)
    with_tabs(page)
    tab = window.page.get_by_role("tab", name="Edit", exact=True)
    expect(tab).to_have_attribute("aria-selected", "true")
    window.page.get_by_role("tab", name="Compare", exact=True).click()
    until(lambda: told, "the tab that was opened")
    assert told == ["compare"], "what Python has asked for is not told back"


def test_a_tab_that_a_person_has_opened_stays_open(page: Page, open_window: Opener) -> None:
    told: list[str] = []
    page.on_tab(told.append)
    with_tabs(page)
    window = open_window(page.url)
    window.page.get_by_role("tab", name="Quality", exact=True).click()
    page.send("tab", "edit")  # the greeting of a busy machine
    until(lambda: told, "the tab that was opened")
    assert told == ["quality"]
    expect(window.page.get_by_role("tab", name="Quality", exact=True)).to_have_attribute("aria-selected", "true")
    page.send("tab", "edit")  # another log
    expect(window.page.get_by_role("tab", name="Edit", exact=True)).to_have_attribute("aria-selected", "true")
