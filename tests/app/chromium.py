"""Looking at the page as people do: open it in the test browser, wait until it is ready, read what it sees."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, expect

ARTEFACTS = Path(__file__).parents[2] / "artefacts"
PATIENCE = 60.0  # s: the slowest machine that tests run on
ROOM = (-3.0, -2.0, 7.0, 4.0)  # m: a rectangle for pages to look at
READY = (
    "window.__viserMutable?.cameraControl && window.splinescope?.camera?.viewport()"
    " && splinescope.latest.has('actions')"
)
GREETED = "!splinescope.latest.has('stage') || splinescope.latest.has('tab')"
"""A page of the whole application has been greeted; one of a bare server has nothing to wait for."""
FRAMES = """
count => new Promise(done => {
  const next = () => (count-- ? requestAnimationFrame(next) : done());
  next();
})
"""
"""So many pictures have been drawn: what was done by mouse or key before has reached the page's script."""

expect.set_options(timeout=30_000)  # a loaded machine takes its time; `until` waits for longer still


@dataclass
class Window:
    """One browser page on one of our servers; `errors` collects what its console complains of."""

    page: Page
    errors: list[str] = field(default_factory=list)

    def ready(self) -> None:
        """Wait until the page can be used, after it was opened or loaded again."""
        self.page.wait_for_function(READY, timeout=1000 * PATIENCE)
        self.settled()
        self.page.wait_for_function(GREETED, timeout=1000 * PATIENCE)

    def viewport(self) -> dict[str, float]:
        """What our script believes to be seen: x, y, metresPerPixel, width, height."""
        return self.page.evaluate("splinescope.camera.viewport()")

    def settled(self) -> dict[str, float]:
        """The same, once it has stopped changing."""
        before, now = {}, self.viewport()
        while before != now:
            self.page.wait_for_timeout(250)
            self.page.evaluate(FRAMES, 6)
            before, now = now, self.viewport()
        return now

    def fit(self) -> dict[str, float]:
        """Show the whole map by its key, which Python answers; what is seen then."""
        number = "splinescope.latest.get('fit')?.number"
        before = self.page.evaluate(number)
        self.page.keyboard.press("f")
        self.page.wait_for_function(f"before => {number} !== before", arg=before)
        return self.settled()

    def pixel_of(self, x: float, y: float) -> tuple[float, float]:
        """Where a point of the world lies in the window (px)."""
        view = self.settled()
        box = self.page.evaluate("(({left, top}) => [left, top])(__viserMutable.canvas.getBoundingClientRect())")
        across = (x - view["x"]) / view["metresPerPixel"] + view["width"] / 2
        down = (view["y"] - y) / view["metresPerPixel"] + view["height"] / 2
        return box[0] + across, box[1] + down

    def camera(self) -> dict[str, list[float]]:
        """The true pose of the camera in the viewer's own axes: position, quaternion, up."""
        return self.page.evaluate(
            "(({position, quaternion, up}) => ({position: position.toArray(), quaternion: quaternion.toArray(),"
            " up: up.toArray()}))(__viserMutable.camera)"
        )

    def node(self, name: str) -> dict[str, Any] | None:
        """What the browser holds of a node of the scene: its segments, and whether it is visible."""
        return self.page.evaluate(
            """name => {
                 const node = __viserSceneTree.getState()[name];
                 if (!node) return null;
                 const count = node.message?.props?.points?.length ?? 0;
                 return { segments: count / 6, visible: __viserMutable.nodeRefFromName[name]?.visible ?? false };
               }""",
            name,
        )

    def screenshot(self, name: str) -> Path:
        """Keep a picture of the page as an artefact of the tests."""
        ARTEFACTS.mkdir(exist_ok=True)
        path = ARTEFACTS / f"{name}.png"
        self.page.screenshot(path=path)
        return path


Opener = Callable[..., Window]
"""Opens a window by url."""


@contextmanager
def opened(browser: Browser, url: str, width: int = 1280, height: int = 720) -> Iterator[Window]:
    """The page at `url`, ready to be used, in a fresh profile."""
    context = browser.new_context(viewport={"width": width, "height": height})
    window = Window(context.new_page())
    window.page.on("console", lambda said: window.errors.append(said.text) if said.type == "error" else None)
    window.page.on("pageerror", lambda error: window.errors.append(str(error)))
    try:
        window.page.goto(f"{url}{'&' if '?' in url else '/?'}fixedDpr=1")
        window.ready()
        yield window
    finally:
        context.close()


def until(condition: Callable[[], Any], what: str, seconds: float = PATIENCE) -> Any:
    """Wait until `condition` gives something true, and return that; fail with `what` was waited for."""
    deadline = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < deadline, f"waited {seconds:g} s in vain for {what}"
        time.sleep(0.02)
    return value
