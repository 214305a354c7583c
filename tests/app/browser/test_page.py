"""The page in a browser: the camera cannot tilt, keys and clicks arrive, the timeline works, strangers stay out."""

from __future__ import annotations

import gzip
import socket
from collections.abc import Callable
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest
from playwright.sync_api import expect
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from app.chromium import Window, until
from bspline_slam.errors import ConfigError
from splinescope import table
from splinescope.actions import ACTIONS, PageRequest, described
from splinescope.actions.page import TABS
from splinescope.browser.page import Mark, Page, TimelineState, open_page

Opener = Callable[..., Window]
ROOM = (-3.0, -2.0, 7.0, 4.0)
PLAYWRIGHT_NAMES = {" ": "Space"}
CAMERA_KEYS = ["w", "a", "s", "d", "q", "e", "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"]


# -- the server --------------------------------------------------------------------------------------------------
def test_the_page_is_ours() -> None:
    page = open_page("127.0.0.1", 0, title="A title of ours")
    try:
        with urlopen(page.url, timeout=10) as answer:
            text = gzip.decompress(answer.read()).decode()
    finally:
        page.stop()
    assert "<title>A title of ours</title>" in text
    assert text.count("static/page.js") == 1
    assert 'href="static/icon.svg"' in text


@pytest.mark.parametrize("path", ["static/none.js", "static/../page.py", "static/%2e%2e/pyproject.toml", "static/"])
def test_only_files_of_the_page_are_served(page: Page, path: str) -> None:
    with pytest.raises(HTTPError, match="404"):
        urlopen(f"{page.url}/{path}", timeout=10)


def test_a_taken_port_is_refused_with_a_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ConfigError, match="is taken by another program: choose another with --port"):
            open_page("127.0.0.1", taken.getsockname()[1])


@pytest.mark.parametrize(
    ("host", "port", "sentence"),
    [
        ("no-such-host.invalid", 0, "is not known on this machine"),
        ("203.0.113.7", 0, "cannot listen on 203.0.113.7"),
        ("127.0.0.1", 70000, "between 0 and 65535"),
    ],
)
def test_an_impossible_address_is_refused_with_a_sentence(host: str, port: int, sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        open_page(host, port)


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:1", None])
def test_other_sites_cannot_connect(page: Page, origin: str | None) -> None:
    with pytest.raises(InvalidStatus, match="403"), connect(page.url.replace("http", "ws"), origin=origin):  # pyright: ignore[reportArgumentType]
        pass


def test_a_name_pointed_at_this_machine_cannot_connect(page: Page) -> None:
    port = page.server.get_port()
    name = f"evil.example:{port}"
    with socket.create_connection(("127.0.0.1", port), timeout=10) as line:
        lines = [f"GET / HTTP/1.1\r\nHost: {name}\r\nOrigin: http://{name}\r\n"]
        lines.append("Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n")
        lines.append("Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n")
        line.sendall("".join(lines).encode())
        assert b"403" in line.recv(64)


def test_beyond_this_machine_only_who_knows_the_token_gets_in(open_window: Opener) -> None:
    page = open_page("0.0.0.0", 0)
    try:
        assert page.token is not None
        page.send("actions", described())
        for path in ("", "/static/page.js", "/?token=", "/?token=wrong"):
            with pytest.raises(HTTPError, match="403"):
                urlopen(f"{page.url}{path}", timeout=10)
        with (
            pytest.raises(InvalidStatus, match="403"),
            connect(page.url.replace("http", "ws"), origin=Origin(page.url)),
        ):
            pass
        with urlopen(page.address, timeout=10) as answer:
            cookie = answer.headers["Set-Cookie"]
        assert page.token in cookie and "HttpOnly" in cookie and "SameSite=Strict" in cookie
        window = open_window(page.address)
        assert page.token not in window.page.url
        assert len(page.server.get_clients()) == 1
    finally:
        page.stop()


# -- the camera --------------------------------------------------------------------------------------------------
def test_the_camera_never_tilts(page: Page, open_window: Opener) -> None:
    page.fit(ROOM)
    window = open_window(page.url)
    straight = window.camera()
    for button in ("left", "middle", "right"):
        before = window.settled()
        window.page.mouse.move(400, 300)
        window.page.mouse.down(button=button)
        window.page.mouse.move(460, 350, steps=4)
        window.page.mouse.up(button=button)
        after = window.settled()
        assert after["x"] == pytest.approx(before["x"] - 60 * before["metresPerPixel"], abs=1e-3)
        assert after["y"] == pytest.approx(before["y"] + 50 * before["metresPerPixel"], abs=1e-3)
        assert after["metresPerPixel"] == pytest.approx(before["metresPerPixel"])
    before = window.settled()
    for key in CAMERA_KEYS:
        window.page.keyboard.down(key)
        window.page.wait_for_timeout(120)
        window.page.keyboard.up(key)
    assert window.settled() == before
    now = window.camera()
    assert now["quaternion"] == pytest.approx(straight["quaternion"], abs=1e-9)
    assert now["up"] == pytest.approx(straight["up"], abs=1e-9)


def test_the_wheel_zooms_about_the_pointer(page: Page, open_window: Opener) -> None:
    page.fit(ROOM)
    window = open_window(page.url)
    at = window.pixel_of(1.0, 1.0)
    before = window.settled()
    window.page.mouse.move(*at)
    window.page.mouse.wheel(0, -240)
    after = window.settled()
    assert after["metresPerPixel"] < 0.9 * before["metresPerPixel"]
    assert window.pixel_of(1.0, 1.0) == pytest.approx(at, abs=1.0)
    window.page.wait_for_timeout(600)
    assert window.settled() == after  # and stays there


def test_a_finger_drags_and_two_fingers_pinch(page: Page, open_window: Opener) -> None:
    page.fit(ROOM)
    window = open_window(page.url)
    straight, before = window.camera(), window.settled()
    fingers = window.page.context.new_cdp_session(window.page)

    def touch(kind: str, *points: tuple[float, float]) -> None:
        at = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})
        window.page.wait_for_timeout(60)

    touch("touchStart", (300, 300))
    for step in range(1, 5):
        touch("touchMove", (300 + 15 * step, 300))
    touch("touchEnd")
    dragged = window.settled()
    assert dragged["x"] < before["x"] - 30 * before["metresPerPixel"]
    touch("touchStart", (300, 300), (400, 300))
    for step in range(1, 5):
        touch("touchMove", (300 - 10 * step, 300 - 5 * step), (400 + 10 * step, 300 + 5 * step))
    touch("touchEnd")
    assert window.settled()["metresPerPixel"] < 0.9 * dragged["metresPerPixel"]
    assert window.camera()["quaternion"] == pytest.approx(straight["quaternion"], abs=1e-9)


def test_buttons_and_keys_zoom(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    window = open_window(page.url)
    page.fit(ROOM)
    until(lambda: window.viewport()["metresPerPixel"] < 0.03, "the fit")
    fitted = window.settled()["metresPerPixel"]
    window.page.get_by_role("button", name="Zoom in").click()  # from here on the page fits nothing by itself
    until(lambda: window.viewport()["metresPerPixel"] < 0.8 * fitted, "the first zoom")
    window.page.wait_for_timeout(2000)
    near = window.settled()["metresPerPixel"]
    for act, zoom in (
        (lambda: window.page.keyboard.press("-"), 1.6),
        (lambda: window.page.keyboard.press("+"), 1.0),
        (lambda: window.page.get_by_role("button", name="Zoom out").click(), 1.6),
        (lambda: window.page.get_by_role("button", name="Zoom in").click(), 1.0),
    ):
        act()
        until(lambda zoom=zoom: window.viewport()["metresPerPixel"] == pytest.approx(zoom * near, rel=0.01), "the zoom")
    window.page.get_by_role("button", name="Show the whole map").click()
    until(lambda: asked, "the action")
    assert asked == ["fit"]


def test_a_fit_shows_the_rectangle_in_every_page(page: Page, open_window: Opener) -> None:
    windows = [open_window(page.url), open_window(page.url, width=900, height=600)]
    page.fit(ROOM)
    for window in windows:
        until(lambda window=window: window.viewport()["metresPerPixel"] < 0.03, "the fit")
        view = window.settled()
        half = 0.5 * view["metresPerPixel"] * np.array([view["width"], view["height"]])
        centre = np.array([view["x"], view["y"]])
        assert (centre - half <= ROOM[:2]).all()
        assert (centre + half >= ROOM[2:]).all()
        assert min(2 * half / np.subtract(ROOM[2:], ROOM[:2])) < 1.6
    until(lambda: len(page.server.get_clients()) == 2, "both pages to connect")
    for client in page.server.get_clients().values():
        bounds = until(lambda client=client: page.bounds_of(client), "what the page sees")
        assert bounds[0] <= ROOM[0] < ROOM[2] <= bounds[2]
        assert page.metres_per_pixel(client) == pytest.approx((bounds[2] - bounds[0]) / page.viewport_of(client).width)  # pyright: ignore[reportOptionalMemberAccess]


def test_the_scale_bar_is_as_long_as_it_says(page: Page, open_window: Opener) -> None:
    page.fit(ROOM)
    window = open_window(page.url)
    for _ in range(3):
        view = window.settled()
        bar = window.page.locator(".scope-bar")
        number, unit = bar.inner_text().split()
        metres = float(number) * {"km": 1000, "m": 1, "cm": 0.01, "mm": 0.001}[unit]
        assert float(bar.evaluate("e => e.style.width.slice(0, -2)")) * view["metresPerPixel"] == pytest.approx(
            metres, rel=1e-3
        )
        assert number.rstrip("0") in ("1", "2", "5")
        window.page.mouse.move(300, 300)
        window.page.mouse.wheel(0, -400)


def test_a_turned_page_has_the_robots_way_up(page: Page, open_window: Opener) -> None:
    clicks: list[np.ndarray] = []
    page.on_click(lambda point, scale, client: clicks.append(point))
    window = open_window(page.url)
    page.look((2.0, 1.0, 0.01))
    page.send("turn", np.pi / 2)
    until(lambda: window.viewport()["turn"] > 1.5, "the turn")
    view = window.settled()
    assert (view["x"], view["y"], view["metresPerPixel"]) == pytest.approx((2.0, 1.0, 0.01), rel=1e-3)
    box = window.page.evaluate("(({left, top}) => [left, top])(__viserMutable.canvas.getBoundingClientRect())")
    window.page.mouse.click(box[0] + view["width"] / 2, box[1] + view["height"] / 2 - 100)
    until(lambda: clicks, "the click")
    assert clicks[0] == pytest.approx([1.0, 1.0], abs=0.02)  # up is where x was falling
    window.page.mouse.move(400, 300)
    window.page.mouse.down()
    window.page.mouse.move(400, 350, steps=4)
    window.page.mouse.up()
    dragged = window.settled()
    assert (dragged["x"], dragged["y"]) == pytest.approx((1.5, 1.0), abs=0.02)
    page.fit(ROOM)
    until(lambda: window.viewport()["metresPerPixel"] > 0.014, "the fit")
    seen = until(lambda: page.viewport if page.viewport and page.viewport.fitted else None, "what the page sees")
    assert seen.bounds[0] <= ROOM[0] < ROOM[2] <= seen.bounds[2]
    page.send("turn", 0.0)
    until(lambda: window.viewport()["turn"] == 0.0, "north up")
    assert window.camera()["up"] == pytest.approx([-1.0, 0.0, 0.0], abs=1e-9)


# -- what people do ----------------------------------------------------------------------------------------------
def test_every_key_asks_for_its_action_and_moves_nothing(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.fit(ROOM)
    window = open_window(page.url)
    before = window.settled()
    table = [(action, key) for action in ACTIONS.values() for key in action.keys]
    told = [(action, key) for action, key in table if action.does not in (PageRequest.SCRIPT, PageRequest.ASK)]
    for _, key in told:
        window.page.keyboard.press(PLAYWRIGHT_NAMES.get(key, key.replace("Ctrl", "Control")))
    until(lambda: len(asked) >= len(told), "the actions")
    assert asked == [action.id for action, _ in told]
    assert window.settled() == before


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


def test_a_question_is_asked_and_its_answer_told(page: Page, open_window: Opener) -> None:
    answers: list[tuple[str, str]] = []
    page.on_answer(lambda action, text: answers.append((action, text)))
    window = open_window(page.url)
    question = window.page.get_by_role("dialog")
    window.page.keyboard.press("G")
    expect(question).to_contain_text("Seconds since the first scan")
    window.page.keyboard.press("Escape")
    expect(question).to_have_count(0)
    window.page.keyboard.press("G")
    window.page.keyboard.type("42.5")
    window.page.keyboard.press("Enter")
    expect(question).to_have_count(0)
    window.page.keyboard.press("O")
    question.get_by_role("button", name="office.log.gz").click()
    until(lambda: len(answers) == 2, "both answers")
    assert answers == [("go-to-second", "42.5"), ("open-log", "office.log.gz")]


def test_keys_do_nothing_on_the_map_while_a_person_types(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.server.gui.add_text("Path", "")
    window = open_window(page.url)
    field = window.page.get_by_role("textbox").first
    field.click()
    window.page.keyboard.type("f a. ")
    assert field.input_value() == "f a. "
    window.page.mouse.click(400, 300)
    window.page.keyboard.press("d")
    until(lambda: asked, "the next key")
    assert asked == ["dark"]


def test_keys_go_to_the_map_again_once_the_mouse_has_worked_a_widget(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    box = page.server.gui.add_checkbox("Beams", False)
    button = page.server.gui.add_button("Optimise")
    presses: list[int] = []
    button.on_click(lambda event: presses.append(1))
    window = open_window(page.url)
    window.page.locator("input[type=checkbox]:visible").click()
    until(lambda: box.value, "the box to be ticked")
    window.page.keyboard.press("Space")
    window.page.get_by_role("button", name="Optimise").click()
    window.page.keyboard.press("Space")
    window.page.keyboard.press("ArrowLeft")
    until(lambda: len(asked) >= 3, "the keys")
    assert asked == ["play", "play", "previous-scan"]
    assert box.value
    window.page.get_by_role("button", name="Optimise").focus()
    window.page.keyboard.press("Space")
    until(lambda: len(presses) == 2, "the focused button to take the key")
    assert asked == ["play", "play", "previous-scan"]


def test_the_palette_finds_an_action_and_does_it(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.send("refusals", {"optimise": "There is no map yet."})
    window = open_window(page.url)
    before = window.settled()
    window.page.keyboard.press("Control+k")
    name = window.page.get_by_role("combobox", name="Name of an action")
    expect(name).to_be_focused()
    name.fill("solve map")
    expect(window.page.get_by_role("option")).to_have_count(1)
    expect(window.page.get_by_role("option")).to_contain_text("There is no map yet.")
    name.fill("10 scans")
    name.press("ArrowDown")
    name.press("Enter")
    until(lambda: asked, "the action")
    assert asked == ["back-10"]
    expect(name).to_be_hidden()
    window.page.keyboard.press("/")
    expect(name).to_be_visible()
    window.page.keyboard.press("Escape")
    expect(name).to_be_hidden()
    assert window.settled() == before


def test_the_help_sheet_names_every_key(page: Page, open_window: Opener) -> None:
    window = open_window(page.url)
    window.page.keyboard.press("?")
    sheet = window.page.get_by_role("dialog", name="Keys and help")
    expect(sheet).to_be_visible()
    shown = sheet.locator("kbd").all_inner_texts()
    assert sorted(shown) == sorted(action.shown for action in ACTIONS.values() if action.keys)
    window.screenshot("help-sheet")
    window.page.keyboard.press("?")
    expect(sheet).to_be_hidden()


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


# -- the timeline ------------------------------------------------------------------------------------------------
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
