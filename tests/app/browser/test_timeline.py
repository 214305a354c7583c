"""The timeline asks, and shows its state."""

from __future__ import annotations

import pytest

from app.chromium import Opener, until
from splinescope.browser.page import Mark, Page, TimelineState


def test_the_timeline_asks_for_what_its_buttons_say(page: Page, open_window: Opener) -> None:
    asked: list[object] = []
    page.on_timeline(lambda command, value: asked.append((command, value)))
    page.on_action(asked.append)
    page.timeline(TimelineState(index=30, length=101, processed=60))
    page_window = open_window(page.url)
    bar = page_window.page.get_by_role("group", name="Timeline")
    for name in ("Forward 1 scan", "Forward 10", "Back 1 scan", "Back 10", "Play"):
        bar.get_by_role("button", name=name).click()
    bar.get_by_label("Playing speed").select_option("5")
    bar.get_by_label("Jump to scan").fill("77")
    bar.get_by_label("Jump to scan").press("Enter")
    until(lambda: len(asked) >= 7, "the requests")
    steps = ["next-scan", "on-10", "previous-scan", "back-10"]
    assert asked == [*steps, "play", ("speed", 5.0), ("seek", 77.0)]
    slider = bar.get_by_label("Scan under the cursor")
    slider.focus()
    box = slider.bounding_box()
    assert box is not None
    page_window.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    until(lambda: len(asked) >= 8, "the seek")
    assert asked[-1] == ("seek", pytest.approx(50.0, abs=2))


def test_the_timeline_shows_its_state_to_pages_that_come_later(page: Page, open_window: Opener) -> None:
    marks = (Mark(3, "key"), Mark(40, "loop"), Mark(50, "lost"))
    page.timeline(TimelineState(30, 101, 60, playing=True, speed=2.0, label="t = 3.0 s", marks=marks))
    page.timeline(TimelineState(31, 101, 60, playing=True, speed=2.0, label="t = 3.1 s", marks=marks))
    window = open_window(page.url)
    bar = window.page.get_by_role("group", name="Timeline")
    bar.get_by_role("button", name="Pause").wait_for()
    assert bar.get_by_label("Jump to scan").input_value() == "31"
    assert "/ 100" in bar.inner_text()
    assert "t = 3.1 s" in bar.inner_text()
    assert bar.get_by_label("Playing speed").input_value() == "2"
    shown = window.page.evaluate("splinescope.latest.get('marks')")
    assert {kind: scans for kind, scans in shown.items() if scans} == {"key": [3], "loop": [40], "lost": [50]}
    window.screenshot("timeline")


def test_arrow_keys_belong_to_the_timeline_even_after_its_buttons_were_used(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.timeline(TimelineState(index=30, length=101, processed=60))
    window = open_window(page.url)
    window.page.get_by_role("button", name="Forward 1 scan").click()
    window.page.keyboard.press("ArrowRight")
    until(lambda: len(asked) >= 2, "the key")
    assert asked == ["next-scan", "next-scan"]


@pytest.mark.parametrize(
    ("typed", "end", "sought"), [("30", "Enter", []), ("77", "Enter", [77.0]), ("77", "Escape", [])]
)
def test_the_field_gives_the_keys_back_to_the_map(
    page: Page, open_window: Opener, typed: str, end: str, sought: list[float]
) -> None:
    asked: list[object] = []
    page.on_timeline(lambda command, value: asked.append(value))
    page.on_action(asked.append)
    page.timeline(TimelineState(index=30, length=101, processed=60))
    window = open_window(page.url)
    field = window.page.get_by_label("Jump to scan")
    field.fill(typed)
    field.press(end)
    window.page.keyboard.press("ArrowRight")
    until(lambda: "next-scan" in asked, "the key")
    assert asked == [*sought, "next-scan"]
    if end == "Escape":
        assert field.input_value() == "30"
