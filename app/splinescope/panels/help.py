"""The help sheet: what the page shows and what the keys do."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

import viser

from splinescope import table
from splinescope.keys import BINDINGS, PageAction
from splinescope.panels.panel import Post, on_press

INTRODUCTION = (
    "A laser log is read scan by scan. Each scan is cut into segments, each segment is fitted with a B-spline curve, "
    "and each curve is either matched to a curve of the map or starts a new one. The map is these curves."
)


class HelpSheet:
    """A window over the page that opens and closes."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._gui, self._post = gui, post
        self._put_away: Callable[[], None] | None = None

    def toggle(self) -> None:
        if self._put_away is None:
            self._open()
        else:
            self.close()

    def close(self) -> None:
        """Put it away if it is open."""
        put_away, self._put_away = self._put_away, None
        if put_away is not None:
            put_away()

    def _open(self) -> None:
        window = self._gui.add_modal("Keys and help")
        self._put_away = window.close
        with window:
            self._gui.add_html(sheet())
            on_press(self._gui.add_button("Close"), lambda: self._post(PageAction.HELP))


def sheet() -> str:
    """The text of the help sheet as HTML."""
    rows = "".join(f"<tr><td><kbd>{escape(b.shown)}</kbd></td><td>{escape(b.says)}</td></tr>" for b in BINDINGS)
    return table.block(
        table.paragraph(INTRODUCTION),
        table.paragraph(
            "Drag to move the map, turn the wheel or press + and − to zoom, click a thing to learn what it is."
        ),
        f'<table class="keys">{rows}</table>',
    )
