"""The camera of a page: it cannot tilt, and mouse, fingers, keys and Python move it."""

from __future__ import annotations

import numpy as np
import pytest

from app.chromium import ROOM, Opener, until
from splinescope.browser.page import Page

CAMERA_KEYS = ["w", "a", "s", "d", "q", "e", "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"]


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
