"""The iterations of the solve behind the result shown, on a slider."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.commands import ShowIteration
from splinescope.panels.panel import Post, on_change
from splinescope.session import Session

MEANING = "0 is where the last adjustment began, the right end is the result. Keys < and > go through them."


class IterationsPanel:
    """A slider over what is kept of the solve; the map in the page goes along."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._slider = gui.add_slider("Iteration", min=0, max=1, step=1, initial_value=1, visible=False)
        self._text = gui.add_html("", visible=False)
        on_change(self._slider, lambda: post(ShowIteration(int(self._slider.value))))

    def refresh(self, session: Session) -> None:
        frames = session.frames
        self._slider.visible = self._text.visible = len(frames) > 1
        if len(frames) < 2:
            return
        last = len(frames) - 1
        shown = last if session.frame is None else session.frame
        if self._slider.max != last:
            self._slider.max = last
        self._slider.value = shown
        frame = frames[shown]
        which = "the result" if shown == last else f"iteration {frame.iteration} of {frames[-1].iteration}"
        text = f"Shown: {which}, cost {frame.cost:,.1f}"
        self._text.content = table.block(table.paragraph(text), table.paragraph(MEANING, "dim"))
