"""Hand edits in a browser: each by mouse and by key, preview, undo and redo, reload, and reopening after kill −9."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from app.chromium import Window, opened, until
from app.running import COMPILING, running_viewer, settled
from bspline_slam.edits.explain import Fate
from bspline_slam.edits.journal import read_journal
from splinescope import commands as ask
from splinescope.browser.preferences import Preferences, save
from splinescope.edits.subject import EditKind
from splinescope.pieces import every_piece, name_of_piece, points_of
from splinescope.view import Selection
from splinescope.viewer import Viewer

LOG = Path(__file__).parents[2] / "sample_logs" / "three_splines.log.gz"
SCAN = 11

Opener = Callable[..., Window]


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    """The application with a finished run; nothing but the map lies where boxes are drawn."""
    memory = tmp_path_factory.mktemp("memory") / "session.json"
    save(Preferences(toured=True), memory)
    with running_viewer(LOG, memory) as viewer:
        yield viewer


@pytest.fixture(scope="module")
def shared(running: Viewer, browser: Browser) -> Iterator[Window]:
    """One window for all tests, for to open one takes seconds; its console has no complaints in the end."""
    with opened(browser, running.url) as window:
        yield window
        assert window.errors == []


@pytest.fixture
def window(shared: Window) -> Window:
    """That window, looking at the whole map."""
    shared.fit()
    return shared


@pytest.fixture
def ready(running: Viewer) -> Viewer:
    """Nothing edited, nothing proposed, a segment of a key scan selected."""
    until(lambda: running.session.editing.base, "the end of processing", COMPILING)
    running.post(ask.DropProposal())
    running.post(ask.GoToEdit(0))
    running.post(ask.Seek(SCAN))
    step = running.session.findings.steps[SCAN]
    longest = max((a for a in step.associations), key=lambda a: a.last - a.first)
    running.post(ask.Select(Selection("segment", longest.segment)))
    made(running, 0, "the automatic map")
    until(lambda: running.session.cursor == SCAN and running.session.selection, "the key scan")
    return running


def in_force(viewer: Viewer) -> int:
    return len(viewer.session.editing.history.active)


def made(viewer: Viewer, count: int, what: str) -> None:
    """Wait until so many edits are in force and their exact map is there."""
    settled(viewer, lambda: in_force(viewer) == count and not viewer.session.editing.making, what)


def open_tab(window: Window, name: str) -> None:
    window.page.get_by_role("tab", name=name, exact=True).click()


def press(page: Page, words: str) -> None:
    """The button with these words on it."""
    page.get_by_role("button", name=words, exact=True).first.click()


def previewed(viewer: Viewer) -> bool:
    proposal = viewer.session.editing.proposal
    return proposal is not None and proposal.preview is not None and proposal.preview.final


BY_KEY = {"Delete": "Ignore beams", "x": "Forbid beams", "w": "Make a new spline", "u": "Split segment", "p": "Pin"}
BY_MOUSE = {"Ignore": "Ignore beams", "Forbid spline": "Forbid beams", "New spline": "Make a new", "Pin": "Pin"}


def test_each_edit_by_key_is_looked_at_accepted_undone_and_redone(ready: Viewer, window: Window) -> None:
    session = ready.session
    for key, name in BY_KEY.items():
        window.page.keyboard.press(key)
        until(lambda: previewed(ready), f"the preview of {name}")
        assert session.editing.proposal is not None and session.editing.proposal.name.startswith(name)
        window.page.keyboard.press("Escape")
        until(lambda: session.editing.proposal is None, "nothing proposed")
        assert in_force(ready) == 0
        window.page.keyboard.press(key)
        until(lambda: previewed(ready), f"the preview of {name}")
        window.page.keyboard.press("Enter")
        made(ready, 1, f"{name} made")
        window.page.keyboard.press("Control+z")
        until(lambda: in_force(ready) == 0, f"{name} undone")
        window.page.keyboard.press("Control+Shift+z")
        until(lambda: in_force(ready) == 1, f"{name} redone")
        window.page.keyboard.press("Control+z")
        made(ready, 0, f"{name} undone again")


def test_edits_by_mouse_with_their_preview_and_explanation(ready: Viewer, window: Window) -> None:
    session = ready.session
    open_tab(window, "Edit")
    for words, name in BY_MOUSE.items():
        press(window.page, words)
        expect(window.page.get_by_text(name).first).to_be_visible()
        until(lambda: previewed(ready), "the preview")
        press(window.page, "Cancel Esc")
        until(lambda: session.editing.proposal is None, "nothing proposed")
    press(window.page, "Ignore")
    expect(window.page.get_by_text("predicted change of cost").first).to_be_visible()
    until(lambda: (window.node("/splinescope/ghost") or {}).get("visible"), "the ghost")
    press(window.page, "Accept ⏎")
    until(lambda: session.editing.explanation, "the explanation")
    expect(window.page.get_by_text("The ten worst residuals")).to_be_visible()
    expect(window.page.get_by_text("✓ followed").first).to_be_visible()
    until(lambda: (window.node("/splinescope/moves") or {}).get("visible"), "lines where poses moved")
    window.page.get_by_role("button", name="scan", exact=False).and_(
        window.page.locator("[data-row=edit-worst] button")
    ).first.click()
    assert session.editing.explanation is not None
    worst = session.editing.explanation.worst[0].scan
    until(lambda: session.cursor == worst, "the scan of the worst residual")
    press(window.page, "Undo")
    until(lambda: in_force(ready) == 0, "undone")
    window.page.locator("[data-row=edit-state][data-number='1'] button").first.click()
    until(lambda: in_force(ready) == 1, "the past state that was clicked")
    window.page.locator("button[data-row=edit-switch]").first.click()
    until(lambda: in_force(ready) == 0, "switched off")


def shown(viewer: Viewer) -> str:
    """A hash of the map and of the edits in force."""
    snapshot, digest = (
        viewer.session.findings.snapshot,
        hashlib.sha256(viewer.session.editing.history.state_hash.encode()),
    )
    assert snapshot is not None
    digest.update(snapshot.poses.tobytes())
    for spline in snapshot.map:
        digest.update(f"{spline.id} {spline.span}".encode() + spline.curve.control_points.tobytes())
    return digest.hexdigest()


def accepted_and_undone(viewer: Viewer, window: Window, name: str) -> None:
    """What is proposed now is previewed, made, seen in the map, taken back, and nothing is left of it."""
    editing = viewer.session.editing
    before, active = shown(viewer), in_force(viewer)
    until(lambda: previewed(viewer), f"the preview of {name}")
    assert editing.proposal is not None and editing.proposal.name.startswith(name)
    assert editing.proposal.preview is not None and editing.proposal.preview.refusal is None
    edits = len(editing.proposal.edits)
    window.page.keyboard.press("Enter")
    made(viewer, active + edits, f"{name} made")
    assert shown(viewer) != before
    assert editing.explanation is not None
    assert {outcome.fate for outcome in editing.explanation.outcomes[active:]} <= {Fate.FOLLOWED, Fate.OUTVOTED}
    press(window.page, "Undo")
    made(viewer, active, f"{name} undone")
    until(lambda: shown(viewer) == before, "the map as it was")


def test_a_box_selects_pieces_and_one_action_edits_them_all(ready: Viewer, window: Window) -> None:
    session = ready.session
    open_tab(window, "Edit")
    scan = session.scan_view
    assert scan is not None
    every = tuple(map(name_of_piece, every_piece(scan)))
    points = np.concatenate([points_of(piece, scan) for piece in every])
    camera = window.camera()
    left, top = window.pixel_of(points[:, 0].min(), points[:, 1].max())
    right, bottom = window.pixel_of(points[:, 0].max(), points[:, 1].min())
    mouse, keyboard = window.page.mouse, window.page.keyboard
    keyboard.down("Shift")
    mouse.move(left - 8, top - 8)
    mouse.down()
    mouse.move(0.5 * (left + right), 0.5 * (top + bottom))
    mouse.move(right + 8, bottom + 8)
    expect(window.page.locator(".scope-box")).to_be_visible()
    window.screenshot("box-drawn")
    mouse.up()
    keyboard.up("Shift")
    expect(window.page.locator(".scope-box")).to_be_hidden()
    wanted = Selection("pieces", SCAN, pieces=every)
    until(lambda: session.selection == wanted, "all pieces")
    assert window.camera() == camera
    expect(window.page.get_by_text(f"{len(every)} pieces selected").first).to_be_visible()
    until(lambda: (window.node("/splinescope/halo") or {}).get("visible"), "what is selected")
    middle = points_of(every[0], scan)
    x, y = window.pixel_of(*middle[len(middle) // 2])
    window.page.keyboard.down("Shift")
    mouse.click(x, y)
    until(lambda: session.selection != wanted, "one piece less")
    mouse.click(x, y)
    window.page.keyboard.up("Shift")
    until(lambda: session.selection == wanted, "the piece again")
    press(window.page, "Ignore")
    until(lambda: previewed(ready), "the preview")
    window.screenshot("box-selected")
    accepted_and_undone(ready, window, f"Ignore {len(every)} pieces of scan {SCAN}")
    keyboard.press("Escape")
    until(lambda: session.selection is None, "nothing selected")
    keyboard.press("Control+a")
    until(lambda: session.selection == wanted, "all pieces by key")


def split_its_spline(viewer: Viewer) -> int:
    """Cut the spline of the selected piece in two, for the others of this world are too far from it; gives its id."""
    piece = viewer.session.subject.piece
    assert piece is not None and piece.spline is not None
    viewer.post(ask.Select(Selection("spline", piece.spline)))
    viewer.post(ask.EditSelected(EditKind.SPLIT))
    viewer.post(ask.AcceptEdits())
    made(viewer, 1, "two splines near each other")
    return piece.spline


def test_a_piece_is_forced_to_another_spline(ready: Viewer, window: Window) -> None:
    open_tab(window, "Edit")
    chosen = ready.session.selection
    split_its_spline(ready)
    ready.post(ask.Select(chosen))
    until(lambda: ready.session.selection == chosen and ready.session.subject.targets, "the segment again")
    press(window.page, "Force to target")
    accepted_and_undone(ready, window, "Force beams")
    window.page.keyboard.press("e")
    accepted_and_undone(ready, window, "Force beams")


def test_splines_are_merged_and_pinned(ready: Viewer, window: Window) -> None:
    open_tab(window, "Edit")
    spline = split_its_spline(ready)
    press(window.page, "Pin")
    accepted_and_undone(ready, window, f"Pin spline {spline}")
    window.page.keyboard.press("p")
    accepted_and_undone(ready, window, f"Pin spline {spline}")
    press(window.page, "Merge")
    accepted_and_undone(ready, window, "Merge spline")
    window.page.keyboard.press("m")
    accepted_and_undone(ready, window, "Merge spline")


def test_a_loop_is_closed_and_dropped(ready: Viewer, window: Window) -> None:
    session = ready.session
    open_tab(window, "Edit")
    world = session.map_view
    assert world is not None
    first = shown(ready)
    ready.post(ask.Select(Selection("key pose", world.key_scans[-1])))
    until(lambda: session.selection is not None and session.selection.kind == "key pose", "the key pose")
    press(window.page, "Close a loop")
    until(lambda: session.editing.picking, "the question which other")
    window.page.mouse.click(*window.pixel_of(*world.key_poses[0, :2]))
    until(lambda: session.editing.draft, "the ghost scan")
    window.page.keyboard.press("Control+ArrowRight")
    press(window.page, "Match it")
    accepted_and_undone(ready, window, "Close a loop")
    window.page.keyboard.press("Control+y")
    made(ready, 1, "the loop closed again")
    assert session.map_view is not None
    ready.post(ask.Select(Selection("closure", len(session.map_view.loop_closures) - 1)))
    until(lambda: session.selection is not None and session.selection.kind == "closure", "the closure")
    press(window.page, "Drop the loop")
    accepted_and_undone(ready, window, "Drop the loop")
    window.page.keyboard.press("Shift+Y")
    accepted_and_undone(ready, window, "Drop the loop")
    press(window.page, "Undo")
    until(lambda: not in_force(ready) and shown(ready) == first, "the automatic map")


def test_a_click_chooses_where_a_spline_is_split(ready: Viewer, window: Window) -> None:
    session = ready.session
    world = session.map_view
    assert world is not None
    spline = world.map.splines[0]
    ready.post(ask.Select(Selection("spline", spline.id)))
    until(lambda: session.selection == Selection("spline", spline.id), "the spline")
    window.page.keyboard.press("Shift+U")
    until(lambda: session.editing.picking, "the question where")
    expect(window.page.get_by_text("Click the place to split it at.").first).to_be_visible()
    x, y = spline.sample(0.1)[1][30]
    window.page.mouse.click(*window.pixel_of(x, y))
    until(lambda: previewed(ready), "the preview")
    assert session.editing.proposal is not None
    assert session.editing.proposal.name.startswith(f"Split spline {spline.id}")


def test_a_page_that_is_loaded_again_shows_the_edits(ready: Viewer, window: Window) -> None:
    window.page.keyboard.press("Delete")
    until(lambda: previewed(ready), "the preview")
    window.page.keyboard.press("Enter")
    made(ready, 1, "the edit made")
    window.page.reload()
    window.ready()
    open_tab(window, "Edit")
    expect(window.page.get_by_text("Ignore beams").first).to_be_visible()
    expect(window.page.get_by_text("✓ followed").first).to_be_visible()


def served(session: Path) -> tuple[subprocess.Popen[str], str]:
    """The program as a person starts it, and its address."""
    command = [sys.executable, "-m", "splinescope", "view", str(LOG), "--port", "0", "--no-browser"]
    process = subprocess.Popen([*command, "--session", str(session)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    words = process.stdout.readline().split()
    return process, next(word for word in words if word.startswith("http"))


def test_after_kill_minus_nine_everything_accepted_is_there_again(tmp_path: Path, open_window: Opener) -> None:
    session = tmp_path / "session.json"
    process, url = served(session)
    window = open_window(url)
    page = window.page
    open_tab(window, "Edit")
    expect(page.get_by_text("No edit was made yet.")).to_be_visible(timeout=1000 * COMPILING)
    expect(page.get_by_text("show one first")).to_be_hidden(timeout=1000 * COMPILING)
    page.keyboard.press("j")
    page.keyboard.press("Delete")
    expect(page.get_by_text("predicted change of cost").first).to_be_visible(timeout=1000 * COMPILING)
    page.keyboard.press("Enter")
    expect(page.get_by_text("As the estimator made it")).to_be_visible()
    os.kill(process.pid, signal.SIGKILL)
    process.wait(10)
    window.errors.clear()
    (journal,) = tmp_path.glob("session.*.edits")
    assert len(read_journal(journal).history.active) == 1
    assert json.loads(journal.read_text().splitlines()[0])["log"] == str(LOG)
    process, url = served(session)
    again = open_window(url)
    try:
        open_tab(again, "Edit")
        expect(again.page.get_by_text("✓ followed").first).to_be_visible(timeout=1000 * COMPILING)
    finally:
        process.kill()
        process.wait(10)
        window.errors.clear()
        again.errors.clear()
