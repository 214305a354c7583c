"""The nodes of the scene: one for each class of things, made once, then only given other values."""

from __future__ import annotations

import numpy as np
import viser

from splinescope.scene.strokes import Strokes

_SRGB = np.arange(256) / 255.0
LINEAR = np.rint(255.0 * np.where(_SRGB <= 0.04045, _SRGB / 12.92, ((_SRGB + 0.055) / 1.055) ** 2.4)).astype(np.uint8)
"""The viewer takes colours of vertices for light, not for the numbers of the screen."""

STEP = 0.05  # m between layers, seen from hundreds of metres: it decides only what covers what


class LineNode:
    """All lines of one class: of one width, each segment with its colour."""

    def __init__(self, server: viser.ViserServer, name: str, layer: float, width: float) -> None:
        self._height = layer * STEP
        self._shown = Strokes.none()
        self._handle = server.scene.add_line_segments(
            f"/splinescope/{name}",
            np.zeros((1, 2, 3), dtype=np.float32),
            np.zeros((1, 2, 3), dtype=np.uint8),
            thickness=width,
            thickness_units="screen",
            visible=False,
        )

    def __len__(self) -> int:
        return len(self._shown) if self._handle.visible else 0

    def show(self, strokes: Strokes) -> None:
        """Draw these instead of what was drawn before; nothing is sent when both are empty."""
        if len(strokes) == 0:
            self.hide()
            return
        points = np.empty((len(strokes), 2, 3), dtype=np.float32)
        points[..., :2] = strokes.segments
        points[..., 2] = self._height
        self._handle.points = points
        self._handle.colors = np.repeat(LINEAR[strokes.colours][:, None], 2, axis=1)
        self._shown = strokes
        self._handle.visible = True

    def hide(self) -> None:
        """Draw nothing."""
        self._handle.visible = False
