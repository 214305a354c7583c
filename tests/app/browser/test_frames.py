"""When the browser draws, and what it draws lines of."""

from __future__ import annotations

import time

import numpy as np

from app.chromium import FRAMES, Opener, Window
from splinescope.browser.page import Page, TimelineState
from splinescope.scene.nodes import LineNode
from splinescope.scene.strokes import Strokes, polyline

COLOUR = np.array([230, 159, 0], dtype=np.uint8)
DRAWN = "__viserTestpoints.rendererInfo.render.frame"
PIECES = """
() => {
  const made = [];
  __viserMutable.nodeRefFromName["/splinescope/walls"].traverse(({ geometry }) => {
    if (!geometry) return;
    const { index, attributes, isInstancedBufferGeometry } = geometry;
    made.push([Boolean(isInstancedBufferGeometry), index.count, attributes.instanceStart.count]);
  });
  return made;
}
"""


def walls(count: int) -> Strokes:
    """A zigzag of so many segments."""
    return Strokes.of(polyline(np.stack([np.arange(count + 1.0), np.arange(count + 1.0) % 2], axis=1)), COLOUR)


def at_rest(window: Window) -> int:
    """The number of the last picture, once no more of them come but for the viewer's one a second."""
    before, now = -1, window.page.evaluate(DRAWN)
    while now - before > 1:
        window.page.wait_for_timeout(900)
        before, now = now, window.page.evaluate(DRAWN)
    return now


def test_lines_are_drawn_in_one_piece_also_after_they_changed(page: Page, open_window: Opener) -> None:
    node = LineNode(page.server, "walls", 1, 2.0)
    node.show(walls(5))
    window = open_window(page.url)
    for count in (5, 70, 3):
        node.show(walls(count))
        window.page.wait_for_function(
            "count => __viserSceneTree.getState()['/splinescope/walls'].message.props.points.length === 6 * count",
            arg=count,
        )
        window.page.evaluate(FRAMES, 4)
        assert window.page.evaluate(PIECES) == [[False, 18 * count, 8 * count]]
    assert window.errors == []


def test_what_is_for_the_script_alone_draws_nothing_and_a_changed_map_does(page: Page, open_window: Opener) -> None:
    node = LineNode(page.server, "walls", 1, 2.0)
    window = open_window(page.url)
    before, start = at_rest(window), time.monotonic()
    for index in range(20):
        page.timeline(TimelineState(index=index, length=101, processed=60))
        window.page.wait_for_function("index => splinescope.latest.get('timeline')?.index === index", arg=index)
    drawn = window.page.evaluate(DRAWN) - before
    assert drawn <= time.monotonic() - start + 5, "the viewer draws once a second, whatever happens"
    before = at_rest(window)
    node.show(walls(9))
    window.page.wait_for_function(f"before => {DRAWN} > before + 2", arg=before)
