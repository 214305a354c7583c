"""Actions that show and hide layers: groups of them by digits, each alone by the palette."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action
from splinescope.view import Layer

SCAN_LAYERS = (
    Layer.BEAMS,
    Layer.NO_RETURN,
    Layer.SEGMENTS,
    Layer.FITS,
    Layer.FIT_POINTS,
    Layer.FIT_ELLIPSES,
    Layer.BREAKS,
    Layer.ASSOCIATIONS,
)
MAP_LAYERS = (
    Layer.SPLINES,
    Layer.COMPARED,
    Layer.CONTROL_POINTS,
    Layer.ELLIPSES,
    Layer.ESTIMATE,
    Layer.ODOMETRY,
    Layer.TRUTH,
    Layer.LOOPS,
    Layer.GRID,
)


def _group(key: str, name: str, words: str, *layers: Layer) -> Action:
    return Action(f"layers-{name}", f"Show or hide {words}", (key,), ask.ToggleLayers(frozenset(layers)))


GROUPS = (
    _group("1", "beams", "the beams", Layer.BEAMS),
    _group("2", "segments", "segments and associations", Layer.SEGMENTS, Layer.ASSOCIATIONS),
    _group("3", "fits", "the curves fitted to the scan", Layer.FITS),
    _group("4", "fit-details", "points and ellipses of the fit", Layer.FIT_POINTS, Layer.FIT_ELLIPSES),
    _group("5", "breaks", "breakpoints and corners", Layer.BREAKS),
    _group("6", "splines", "the splines of the map", Layer.SPLINES),
    _group("7", "map-details", "points and ellipses of the map", Layer.CONTROL_POINTS, Layer.ELLIPSES),
    _group("8", "paths", "the trajectories", Layer.ESTIMATE, Layer.ODOMETRY, Layer.TRUTH),
    _group("9", "loops", "loop closures", Layer.LOOPS),
    _group("0", "compared", "the compared result", Layer.COMPARED),
)

SINGLE = tuple(
    Action(
        f"layer-{layer.name.lower().replace('_', '-')}",
        f"Layer: {layer.value}",
        (),
        ask.ToggleLayers(frozenset({layer})),
    )
    for layer in SCAN_LAYERS + MAP_LAYERS
)
"""Layers one by one, for the palette."""
