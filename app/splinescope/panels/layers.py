"""The layers: everything that can be shown or hidden, for the current scan and for the map."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.actions.layers import MAP_LAYERS, SCAN_LAYERS
from splinescope.commands import SetColouring, SetLayer
from splinescope.grades import scale_of
from splinescope.panels.panel import Post, on_change
from splinescope.session import Session
from splinescope.view import Colouring, Layer


class LayersPanel:
    """One checkbox per layer; the choice is remembered."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._boxes: dict[Layer, viser.GuiCheckboxHandle] = {}
        for title, layers in (("This scan", SCAN_LAYERS), ("Map", MAP_LAYERS)):
            with gui.add_folder(title):
                for layer in layers:
                    self._add(gui, post, layer)
        labels = tuple(colouring.value for colouring in Colouring)
        self._colouring = gui.add_dropdown("Colour of curves", labels, hint="Key C changes to the next")
        on_change(self._colouring, lambda: post(SetColouring(Colouring(self._colouring.value))))
        self._why = gui.add_html("")

    def _add(self, gui: viser.GuiApi, post: Post, layer: Layer) -> None:
        box = self._boxes[layer] = gui.add_checkbox(layer.value, initial_value=False)
        on_change(box, lambda: post(SetLayer(layer, box.value)))

    def refresh(self, session: Session) -> None:
        shown = session.preferences.layers
        for layer, box in self._boxes.items():
            box.value = layer in shown
        self._colouring.value = session.preferences.colouring.value
        reasons = [reason for layer, reason in missing(session) if layer in shown]
        reasons += uncoloured(session)
        self._why.content = table.block(*(table.paragraph(reason, "dim") for reason in reasons))
        self._why.visible = bool(reasons)


def uncoloured(session: Session) -> list[str]:
    """Why the curves keep their own colours although something else was chosen."""
    chosen = session.preferences.colouring
    if session.map_view is None or chosen is Colouring.SPLINE or scale_of(session.map_view, chosen) is not None:
        return []
    return [f"The curves are coloured by {chosen.value} when processing or optimising has ended."]


def missing(session: Session) -> list[tuple[Layer, str]]:
    """Layers that have nothing to show now, and why."""
    gone: list[tuple[Layer, str]] = []
    if session.log is None:
        return gone
    if session.log.truth is None:
        gone.append((Layer.TRUTH, "This log has no ground truth."))
    if session.log.odometry is None:
        gone.append((Layer.ODOMETRY, "This log has no odometry."))
    if not session.findings.covariances:
        gone.append((Layer.ELLIPSES, "The ellipses of the map are computed when processing or optimising has ended."))
    return gone
