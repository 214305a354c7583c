"""The left side: what is shown of the map, and which log it is made of."""

from __future__ import annotations

import viser

from splinescope.panels.layers import LayersPanel
from splinescope.panels.log import LogPanel
from splinescope.panels.panel import Panel, Post
from splinescope.panels.picture import PicturePanel
from splinescope.session import Session

WIDTH = 262.0


class LogSide:
    """A panel of its own beside the map, with the layers and the log under tabs; an observation takes its place."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        panel = self._panel = gui.add_panel()
        self._panels: list[Panel] = []
        with panel.add_tab("Layers"):
            self._panels.append(LayersPanel(gui, post))
            with gui.add_folder("Picture"):
                self._panels.append(PicturePanel(gui, post))
        with panel.add_tab("Log"):
            self._panels.append(LogPanel(gui, post))
        panel.dock_left()
        panel.set_width(WIDTH)

    def refresh(self, session: Session) -> None:
        self._panel.visible = not session.observing
        for panel in self._panels:
            panel.refresh(session)
