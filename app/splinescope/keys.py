"""One table of keys: what each does, and what the help sheet says about it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from splinescope import commands as ask
from splinescope.view import Layer


class PageAction(Enum):
    """What concerns the page that the key was pressed in, not the session."""

    FIT = "fit"
    HELP = "help"
    ESCAPE = "escape"
    OPTIMISE = "optimise"
    FOLLOW_PROCESSING = "follow processing"
    FOLLOW_ROBOT = "follow robot"


@dataclass(frozen=True, slots=True)
class KeyBinding:
    """Names of keys (as the page reports them) that do the same thing; `shown` is how the help sheet writes them."""

    names: tuple[str, ...]
    shown: str
    says: str
    does: ask.Command | PageAction


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
    Layer.RESIDUALS,
    Layer.COMPARED,
    Layer.CONTROL_POINTS,
    Layer.ELLIPSES,
    Layer.ESTIMATE,
    Layer.ODOMETRY,
    Layer.TRUTH,
    Layer.LOOPS,
    Layer.GRID,
)


def _layers(key: str, says: str, *layers: Layer) -> KeyBinding:
    return KeyBinding((key,), key, f"show or hide {says}", ask.ToggleLayers(frozenset(layers)))


BINDINGS: tuple[KeyBinding, ...] = (
    KeyBinding((" ",), "Space", "play or pause; at the end, from the start", ask.TogglePlay()),
    KeyBinding(("ArrowRight", "."), "→ or .", "next scan", ask.Step(1)),
    KeyBinding(("ArrowLeft", ","), "← or ,", "previous scan", ask.Step(-1)),
    KeyBinding(("Shift+ArrowRight",), "Shift + →", "ten scans on", ask.Step(10)),
    KeyBinding(("Shift+ArrowLeft",), "Shift + ←", "ten scans back", ask.Step(-10)),
    KeyBinding(("Home",), "Home", "first scan", ask.Seek(0)),
    KeyBinding(("End",), "End", "last scan", ask.Seek(-1)),
    KeyBinding(("]",), "]", "play faster", ask.ChangeSpeed(1)),
    KeyBinding(("[",), "[", "play slower", ask.ChangeSpeed(-1)),
    KeyBinding(("l",), "l", "show the newest processed scan, or let go", PageAction.FOLLOW_PROCESSING),
    KeyBinding(("r",), "r", "keep the robot in the middle, or let go", PageAction.FOLLOW_ROBOT),
    KeyBinding(("f",), "f", "fit: show the whole map", PageAction.FIT),
    KeyBinding(("d",), "d", "dark or light page", ask.SetDark()),
    KeyBinding(("o",), "o", "optimise the whole map", PageAction.OPTIMISE),
    KeyBinding(("s",), "s", "step through the observation of the selected segment, or close it", ask.ShowObservation()),
    KeyBinding(("n",), "n", "next step of it", ask.StepObservation(1)),
    KeyBinding(("b",), "b", "step back in it", ask.StepObservation(-1)),
    KeyBinding(("Escape",), "Esc", "clear the selection, close this sheet", PageAction.ESCAPE),
    KeyBinding(("?",), "?", "this sheet", PageAction.HELP),
    _layers("1", "the beams", Layer.BEAMS),
    _layers("2", "segments and associations", Layer.SEGMENTS, Layer.ASSOCIATIONS),
    _layers("3", "the curves fitted to the scan", Layer.FITS),
    _layers("4", "points and ellipses of the fit", Layer.FIT_POINTS, Layer.FIT_ELLIPSES),
    _layers("5", "breakpoints and corners", Layer.BREAKS),
    _layers("6", "the splines of the map", Layer.SPLINES),
    _layers("c", "the residuals along the curves (crispness)", Layer.RESIDUALS),
    _layers("7", "points and ellipses of the map", Layer.CONTROL_POINTS, Layer.ELLIPSES),
    _layers("8", "the trajectories", Layer.ESTIMATE, Layer.ODOMETRY, Layer.TRUTH),
    _layers("0", "the compared result", Layer.COMPARED),
    _layers("9", "loop closures", Layer.LOOPS),
)

_BY_NAME = {name: binding for binding in BINDINGS for name in binding.names}


def binding_of(name: str) -> KeyBinding | None:
    """What the key called `name` does; None for a key without a meaning."""
    return _BY_NAME.get(name)
