"""The side bar: all panels in their places."""

from __future__ import annotations

import viser

from splinescope.panels.calibration import CalibrationPanel
from splinescope.panels.closures import ClosuresPanel
from splinescope.panels.compare import ComparePanel
from splinescope.panels.consistency import ConsistencyPanel
from splinescope.panels.crispness import CrispnessPanel
from splinescope.panels.decisions import DecisionsPanel
from splinescope.panels.editing import EditPanel
from splinescope.panels.estimate import EstimatePanel
from splinescope.panels.inspector import InspectorPanel
from splinescope.panels.iterations import IterationsPanel
from splinescope.panels.log_side import LogSide
from splinescope.panels.lost import LostPanel
from splinescope.panels.observation import ObservationPanel
from splinescope.panels.panel import Panel, Post
from splinescope.panels.status import StatusPanel
from splinescope.panels.style import STYLE
from splinescope.panels.timeline import TimelinePanel
from splinescope.session import Session


class SideBar:
    """On the right status and inspector, always in sight, and the work under tabs; on the left layers and log.

    Observations have a window of their own.
    """

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        gui.add_html(STYLE)
        self._panels: list[Panel] = [StatusPanel(gui, post), InspectorPanel(gui, post)]
        tabs = gui.add_tab_group()
        with tabs.add_tab("Scan"):
            self._panels.append(DecisionsPanel(gui, post))
            with gui.add_folder("Time and place"):
                self._panels.append(TimelinePanel(gui, post))
        with tabs.add_tab("Edit"):
            self._panels.append(EditPanel(gui, post))
        with tabs.add_tab("Estimate"):
            self._panels.append(EstimatePanel(gui, post))
            self._panels.append(IterationsPanel(gui, post))
        with tabs.add_tab("Compare"):
            self._panels.append(ComparePanel(gui, post))
        with tabs.add_tab("Quality"):
            for panel in (CrispnessPanel, ClosuresPanel, LostPanel, CalibrationPanel, ConsistencyPanel):
                self._panels.append(panel(gui, post))
        self._panels += [LogSide(gui, post), ObservationPanel(gui, post)]

    def refresh(self, session: Session) -> None:
        for panel in self._panels:
            panel.refresh(session)
