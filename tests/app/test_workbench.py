"""The whole application in a browser: load, step, layers, inspector, optimise, errors, two at once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from app.chromium import Opener, Window, until
from app.logs import corridor_log, write_carmen
from app.running import COMPILING, running_viewer
from splinescope import commands as ask
from splinescope.actions import ACTIONS
from splinescope.actions.page import TABS
from splinescope.browser.link import Link
from splinescope.browser.preferences import FIRST_LAYERS, Preferences, load, save
from splinescope.grades import WIDTHS
from splinescope.view import Colouring, Layer, Selection
from splinescope.viewer import Viewer

SCANS = 60


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = corridor_log(np.random.default_rng(6), SCANS)
    return write_carmen(made, tmp_path_factory.mktemp("logs") / "corridor.log")


@pytest.fixture(scope="module")
def memory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("memory") / "session.json"


@pytest.fixture(scope="module")
def running(log: Path, memory: Path) -> Iterator[Viewer]:
    """The application with a log that it processes."""
    save(Preferences(layers=Preferences().layers | {Layer.CONTROL_POINTS}, toured=True), memory)
    with running_viewer(log, memory) as viewer:
        yield viewer


@pytest.fixture
def ready(running: Viewer, log: Path) -> Viewer:
    """The application, its log processed, standing on a key scan; what an earlier test cancelled is done again."""
    session = running.session
    cancelled = session.solution and not session.busy and not session.findings.covariances
    if session.opening is None and (session.title != log.name or cancelled):
        running.post(ask.OpenLog(log))
    until(lambda: session.solution and session.findings.covariances, "the end of processing", COMPILING)
    running.post(ask.Select(None))
    running.post(ask.Seek(0))
    until(lambda: running.session.cursor == 0 and running.session.selection is None, "the first scan")
    return running


def tab(window: Window, name: str) -> None:
    window.page.get_by_role("tab", name=name, exact=True).click()


def test_a_log_can_be_stepped_at_once_and_arrives_by_and_by(running: Viewer, open_window: Opener) -> None:
    window = open_window(running.url)
    expect(window.page.get_by_text("corridor.log").first).to_be_visible()
    window.page.keyboard.press("Home")
    window.page.keyboard.press("ArrowRight")
    until(lambda: running.session.cursor == 1, "a step")
    until(lambda: running.session.solution, "the end of processing", COMPILING)
    expect(window.page.get_by_text("The log is processed")).to_be_visible()
    assert running.session.cursor == 1


def test_steps_by_key_and_by_button(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    counter = window.page.get_by_label("Jump to scan")
    for key, index in (("ArrowRight", 1), ("Shift+ArrowRight", 11), (",", 10), ("End", SCANS - 1), ("Home", 0)):
        window.page.keyboard.press(key)
        expect(counter).to_have_value(str(index))
    window.page.get_by_label("Forward 1 scan").click()
    expect(counter).to_have_value("1")
    window.page.get_by_label("Forward 10 scans").click()
    expect(counter).to_have_value("11")
    window.page.keyboard.press("End")
    window.page.get_by_label("Playing speed").select_option("0.25")  # so slow that the end is far for any machine
    window.page.keyboard.press(" ")
    until(lambda: 0 < ready.session.cursor < SCANS - 1, "play from the start")
    assert ready.session.playback.playing
    window.page.keyboard.press(" ")
    until(lambda: not ready.session.playback.playing, "pause")
    ready.post(ask.SetSpeed(2.0))


def test_layers_are_switched_and_remembered(ready: Viewer, open_window: Opener, memory: Path) -> None:
    window = open_window(ready.url)
    tab(window, "Layers")
    box = window.page.get_by_label(Layer.BEAMS.value, exact=True)
    expect(box).to_be_checked()
    box.click()
    until(lambda: Layer.BEAMS not in ready.session.preferences.layers, "the beams to go")
    until(lambda: Layer.BEAMS not in load(memory).layers, "the choice to be kept")
    window.page.keyboard.press("1")
    expect(box).to_be_checked()
    until(lambda: Layer.BEAMS in load(memory).layers, "the choice to be kept")


def test_a_click_on_a_spline_shows_it_in_the_inspector(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    ready.post(ask.SetLayer(Layer.SEGMENTS, False))
    world = ready.session.map_view
    assert world is not None
    spline = max(world.map, key=lambda s: s.length)
    x, y = spline.curve(np.array([spline.span[0] + 0.41 * (spline.span[1] - spline.span[0])]))[0]
    window.page.mouse.click(*window.pixel_of(x, y))
    until(lambda: ready.session.selection, "something selected")
    assert ready.session.selection is not None
    assert ready.session.selection.id == spline.id
    expect(
        window.page.get_by_text(f"spline {spline.id}").or_(window.page.get_by_text(f"Spline {spline.id}")).first
    ).to_be_visible()
    window.page.keyboard.press("Escape")
    until(lambda: ready.session.selection is None, "nothing selected")
    ready.post(ask.SetLayer(Layer.SEGMENTS, True))


def test_decisions_are_listed_and_a_row_selects_its_segment(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    tab(window, "Scan")
    scan = ready.session.scan_view
    assert scan is not None
    assert scan.key
    expect(window.page.get_by_text(f"{len(scan.associations)} decisions")).to_be_visible()
    window.page.locator("[data-row=segment][data-number='0'] button").first.click()
    expect(window.page.get_by_text("Segment 0 of scan 0")).to_be_visible()
    ready.post(ask.Seek(next(i for i in range(SCANS) if not ready.session.findings.steps[i].key)))
    expect(window.page.get_by_text("is not a key scan").first).to_be_visible()


def test_optimising_lowers_the_cost_and_says_what_it_did(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url, width=1920, height=1080)
    tab(window, "Estimate")
    window.page.get_by_role("button", name="Only solve this map again").click()
    expect(window.page.get_by_text("The map is optimised")).to_be_visible(timeout=1000 * COMPILING)
    expect(window.page.get_by_text("cost before → after")).to_be_visible()
    expect(window.page.locator(".uplot")).to_be_visible()
    solution = ready.session.solution
    assert solution is not None
    assert solution.cost_after <= solution.cost_before
    window.screenshot("workbench")


def test_quality_is_measured_and_colours_the_curves(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    tab(window, "Quality")
    expect(window.page.get_by_text("Crispness: ")).to_be_visible()
    expect(window.page.get_by_role("img", name="Histogram of the distances")).to_be_visible()
    expect(window.page.get_by_text("range noise")).to_be_hidden()
    window.page.get_by_text("Calibration", exact=True).click()
    expect(window.page.get_by_text("range noise")).to_be_visible()
    expect(window.page.get_by_text("Lost scans: ")).to_be_visible()
    window.page.get_by_label("Colour the curves by it").click()
    until(lambda: ready.session.preferences.colouring is Colouring.RESIDUAL, "the colouring")
    names = [f"/splinescope/graded {number}" for number in range(len(WIDTHS))]
    until(lambda: any((window.node(name) or {}).get("visible") for name in names), "coloured curves")
    window.screenshot("quality")
    for colouring in (Colouring.UNCERTAINTY, Colouring.OBSERVATIONS, Colouring.AGE, Colouring.SPLINE):
        window.page.keyboard.press("c")
        until(lambda c=colouring: ready.session.preferences.colouring is c, "the next colouring")


WILD = """
([seed, count]) => {
  const next = () => (seed = (1103515245 * seed + 12345) % 2147483648) / 2147483648;
  const any = (list) => list[Math.floor(next() * list.length)];
  const canvas = __viserMutable.canvas, box = canvas.getBoundingClientRect();
  for (let i = 0; i < count; i++) {
    const kind = next();
    if (kind < 0.55) {
      const [key, more] = any(window.wildKeys);
      const open = document.querySelector("dialog[open]");
      const target = open?.querySelector("input") ?? open ?? document.body;
      target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
    } else if (kind < 0.8) {
      const at = { clientX: box.left + next() * box.width, clientY: box.top + next() * box.height, button: 0,
                   pointerId: 1, isPrimary: true, bubbles: true };
      canvas.dispatchEvent(new PointerEvent("pointerdown", at));
      canvas.dispatchEvent(new PointerEvent("pointerup", at));
    } else if (kind < 0.9) {
      any([...document.querySelectorAll(".scope-button, header .scope-close, .scope-legend summary")]).click();
    } else {
      const tab = any([...document.querySelectorAll("[role=tab]")]);
      tab.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", code: "Enter", bubbles: true }));
    }
  }
  return seed;
}
"""
"""So many things that a person could do, in no order: keys, clicks in the map, on buttons and on tabs."""


def test_two_thousand_wild_events_leave_a_page_that_works(ready: Viewer, open_window: Opener) -> None:
    window, seed = open_window(ready.url), 7
    heavy = {"run", "optimise", "open-sample", "copy-link"}
    names = [key for action in ACTIONS.values() for key in action.keys if action.id not in heavy]
    window.page.evaluate("keys => (window.wildKeys = keys)", [[*pressed(name)] for name in names])
    for _ in range(40):
        seed = window.page.evaluate(WILD, [seed, 50])
        window.page.wait_for_timeout(20)
    for _ in range(4):
        window.page.keyboard.press("Escape")
    expect(window.page.locator("dialog[open]")).to_have_count(0)
    until(lambda: ready.session.opening is None and not ready.session.busy, "rest", COMPILING)
    assert ready.session.title == "corridor.log"
    assert not [trouble for trouble in ready.session.troubles if "Something went wrong" in trouble]
    window.page.keyboard.press("End")
    until(lambda: ready.session.cursor == SCANS - 1, "a step after all that")
    assert window.camera()["up"][1] == pytest.approx(0.0, abs=1e-9)
    for command in (ask.RobotUp(False), ask.FollowRobot(False), ask.SetDark(True), ask.SetColouring(Colouring.SPLINE)):
        ready.post(command)
    ready.post(ask.ShowObservation(False))
    for layer in Layer:
        ready.post(ask.SetLayer(layer, layer in FIRST_LAYERS))


def pressed(name: str) -> tuple[str, dict[str, bool]]:
    """A key by its name, as an event tells it."""
    *modifiers, key = name.split("+") if len(name) > 1 else [name]
    return key, {"shiftKey": "Shift" in modifiers, "ctrlKey": "Ctrl" in modifiers, "altKey": "Alt" in modifiers}


def test_a_bad_file_is_a_sentence_and_the_open_log_stays(ready: Viewer, open_window: Opener, tmp_path: Path) -> None:
    bad = tmp_path / "<b>bad.log"
    bad.write_bytes(bytes(range(256)) * 4)
    window = open_window(ready.url)
    tab(window, "Log")
    window.page.get_by_role("button", name="By its path").click()
    window.page.get_by_label("A file or folder").fill(str(bad))
    window.page.keyboard.press("Enter")
    expect(window.page.get_by_text("This log cannot be opened")).to_be_visible()
    until(lambda: ready.session.troubles, "the sentence")
    expect(window.page.locator(".ss .bad")).to_contain_text("<b>bad.log")
    assert ready.session.title == "corridor.log"
    assert ready.session.findings.snapshot is not None


def test_a_file_can_be_uploaded(ready: Viewer, open_window: Opener, log: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.log"
    other.write_text("".join(log.read_text(encoding="utf-8").splitlines(keepends=True)[:8]), encoding="utf-8")
    window = open_window(ready.url)
    tab(window, "Log")
    with window.page.expect_file_chooser() as chooser:
        window.page.get_by_role("button", name="Upload a file").click()
    chooser.value.set_files(other)
    until(lambda: ready.session.title == "other.log", "the uploaded log")
    assert ready.session.playback.count == 8


def test_one_drives_and_others_watch_until_they_take_control(ready: Viewer, open_window: Opener) -> None:
    one, two = open_window(ready.url), open_window(ready.url)
    expect(two.page.get_by_text("You are watching")).to_be_visible()
    expect(one.page.get_by_text("One other page watches.")).to_be_visible()
    one.page.keyboard.press("Shift+ArrowRight")
    expect(two.page.get_by_label("Jump to scan")).to_have_value("10")
    before = two.settled()
    two.page.keyboard.press("ArrowRight")
    expect(two.page.get_by_text("Another page drives what all see")).to_be_visible()
    tab(two, "Layers")  # another test may have left another one open
    two.page.get_by_label(Layer.BEAMS.value, exact=True).click()
    two.page.get_by_role("button", name="Zoom in").click()
    until(lambda: two.viewport()["metresPerPixel"] < 0.9 * before["metresPerPixel"], "a view of one's own")
    assert ready.session.cursor == 10
    assert Layer.BEAMS in ready.session.preferences.layers
    two.page.keyboard.press("a")
    expect(one.page.get_by_text("Somebody else drives now")).to_be_visible()
    expect(one.page.get_by_role("button", name="Take control")).to_be_visible()
    two.page.keyboard.press("d")
    expect(one.page.locator("html.scope-light")).to_be_attached()
    one.screenshot("workbench-light")
    two.page.keyboard.press("d")
    until(lambda: ready.session.preferences.dark, "a dark page")
    two.page.reload()
    two.ready()
    expect(two.page.get_by_text("One other page watches.")).to_be_visible()
    two.page.keyboard.press("Home")
    until(lambda: ready.session.cursor == 0, "the driver to drive on after a reload")


@pytest.mark.parametrize("touched", [True, False])
def test_a_page_that_comes_back_goes_on_where_it_was(
    ready: Viewer, open_window: Opener, monkeypatch: pytest.MonkeyPatch, touched: bool
) -> None:
    """Whether it drives or watches, its place and its tab are its own, whatever others look at."""
    windows = one, two = open_window(ready.url), open_window(ready.url)
    one.page.keyboard.press("+")
    if touched:
        two.page.keyboard.press("-")
    tab(two, "Quality")
    places = [window.settled() for window in windows]
    assert places[0]["metresPerPixel"] != pytest.approx(places[1]["metresPerPixel"])
    greeted, greet = [], ready._presenter.greet_again
    monkeypatch.setattr(ready._presenter, "greet_again", lambda *told: (greet(*told), greeted.append(told)))
    ready._page.server._websock_server.disconnect_all_clients()
    until(lambda: len(greeted) == 2, "both pages to come back")
    for window, place in zip(windows, places, strict=True):
        until(lambda window=window, place=place: window.settled() == pytest.approx(place, abs=0.01), "its own place")
        expect(window.page.get_by_role("alert")).to_be_hidden()
        window.errors.clear()  # the browser says that the connection was lost
    expect(two.page.get_by_role("tab", name="Quality")).to_have_attribute("aria-selected", "true")


def test_every_setting_of_the_view_survives_a_reload(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    page = window.page
    for key in ("Shift+ArrowRight", "j", "4", "c"):
        page.keyboard.press(key)
    tab(window, "Quality")
    page.mouse.move(300, 300)
    page.mouse.wheel(0, -300)
    before = window.settled()
    place = pytest.approx((before["x"], before["y"], before["metresPerPixel"]))
    until(lambda: ready.session.place == place, "the place")
    until(lambda: "quality" in ready.session.tab and ready.session.selection, "all of it")
    said = ready.session.remembered
    page.reload()
    window.ready()
    until(lambda: window.viewport()["metresPerPixel"] == pytest.approx(before["metresPerPixel"], rel=1e-3), "the place")
    after = window.settled()
    assert (after["x"], after["y"]) == pytest.approx((before["x"], before["y"]), abs=0.01)
    expect(page.get_by_role("tab", name="Quality", exact=True)).to_have_attribute("aria-selected", "true")
    expect(page.get_by_label("Jump to scan")).to_have_value("10")
    assert ready.session.remembered.layers == said.layers
    assert (ready.session.selection, ready.session.cursor) == (Selection("segment", 0), 10)
    ready.post(ask.SetColouring(Colouring.SPLINE))
    page.keyboard.press("4")
    tab(window, "Layers")


def test_a_link_opens_its_moment(ready: Viewer, open_window: Opener) -> None:
    window = open_window(f"{ready.url}/?scan=33&layers=beams,grid,splines&camera=2.5,1.5,0.012&colour=age")
    page = window.page
    expect(page.get_by_label("Jump to scan")).to_have_value("33")
    view = window.settled()
    assert (view["x"], view["y"], view["metresPerPixel"]) == pytest.approx((2.5, 1.5, 0.012), rel=1e-3)
    assert ready.session.preferences.layers == {Layer.BEAMS, Layer.GRID, Layer.SPLINES}
    assert ready.session.preferences.colouring is Colouring.AGE
    assert "scan=" not in page.url
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.keyboard.press("L")
    expect(page.get_by_text("The link is copied.")).to_be_attached()
    link = Link.parse(page.evaluate("navigator.clipboard.readText()").partition("?")[2])
    assert link == Link(33, ready.session.preferences.layers, pytest.approx((2.5, 1.5, 0.012), rel=1e-3), Colouring.AGE)  # pyright: ignore[reportArgumentType]
    ready.post(ask.SetColouring(Colouring.SPLINE))
    for layer in FIRST_LAYERS:
        ready.post(ask.SetLayer(layer, True))


def test_every_tab_is_opened_from_the_palette(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    names = window.page.get_by_role("tab").all_inner_texts()
    assert tuple(names) == TABS
    for name in names[::-1]:
        window.page.keyboard.press("/")
        window.page.keyboard.type(f"tab {name}")
        window.page.keyboard.press("Enter")
        expect(window.page.get_by_role("tab", name=name, exact=True)).to_have_attribute("aria-selected", "true")


def test_the_help_sheet_opens_and_closes(ready: Viewer, open_window: Opener) -> None:
    window = open_window(ready.url)
    window.page.keyboard.press("?")
    sheet = window.page.get_by_text("Play or pause; at the end")
    expect(sheet).to_be_visible()
    hidden = window.page.get_by_role("dialog").evaluate("sheet => sheet.scrollHeight - sheet.clientHeight")
    assert hidden <= 0, "all of it is seen at once"
    window.page.get_by_role("button", name="Close", exact=True).click()
    expect(sheet).to_be_hidden()
