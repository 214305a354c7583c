"""What is remembered from one visit to the next: layers, theme, speed, views of logs; a small JSON file."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from bspline_slam.errors import ConfigError
from splinescope.browser.log_view import LogView
from splinescope.view import Colouring, Layer

log = logging.getLogger(__name__)

FIRST_LAYERS = frozenset(
    {
        Layer.BEAMS,
        Layer.SEGMENTS,
        Layer.FITS,
        Layer.ASSOCIATIONS,
        Layer.SPLINES,
        Layer.COMPARED,
        Layer.ESTIMATE,
        Layer.ODOMETRY,
        Layer.GRID,
    }
)
"""Layers that a first visitor sees."""
MOST_VIEWS = 50
"""Logs whose views are remembered."""


@dataclass(frozen=True, slots=True)
class Preferences:
    """Choices of the person that outlive a page and a process; `views` by the content hash of each log, newest
    last; `log` is the path of the one that was open last, and `log_hash` its content hash."""

    layers: frozenset[Layer] = FIRST_LAYERS
    dark: bool = True
    follow_robot: bool = False
    speed: float = 2.0
    colouring: Colouring = Colouring.SPLINE
    robot_up: bool = False
    toured: bool = False
    views: Mapping[str, LogView] = field(default_factory=dict)
    log: str = ""
    log_hash: str = ""

    def with_view(self, content_hash: str, view: LogView) -> Preferences:
        """The same, and how the log of this hash was looked at last; the oldest are forgotten."""
        others = {known: kept for known, kept in self.views.items() if known != content_hash}
        return replace(self, views=dict([*others.items(), (content_hash, view)][-MOST_VIEWS:]))

    def to_json(self) -> str:
        """The file's text; layers and colouring by their names in the code, which outlive their labels."""
        names = {"layers": sorted(layer.name for layer in self.layers), "colouring": self.colouring.name}
        return json.dumps(asdict(self) | names, indent=2)

    @staticmethod
    def from_json(text: str) -> Preferences:
        """What a file's text says; what it does not say, or says wrongly, stays as on a first visit."""
        first = Preferences()
        try:
            told = json.loads(text)
        except ValueError:
            return first
        if not isinstance(told, dict):
            return first
        return replace(first, **_understood(told))


def _understood(told: dict[str, Any]) -> dict[str, Any]:
    kinds = {"dark": bool, "follow_robot": bool, "robot_up": bool, "toured": bool}
    kinds |= {"speed": float, "log": str, "log_hash": str}
    known = {name: told[name] for name, kind in kinds.items() if isinstance(told.get(name), kind)}
    if isinstance(told.get("layers"), list):
        known["layers"] = frozenset(layer for layer in Layer if layer.name in told["layers"])
    if told.get("colouring") in Colouring.__members__:
        known["colouring"] = Colouring[told["colouring"]]
    if isinstance(told.get("views"), dict):
        known["views"] = {str(log): LogView.from_json(view) for log, view in told["views"].items()}
    return known


def default_path() -> Path:
    """Where preferences are kept unless told otherwise: the user's configuration folder."""
    base = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(base) / "splinescope" / "session.json"


def load(path: Path) -> Preferences:
    """The preferences kept at `path`; those of a first visit where there are none."""
    try:
        return Preferences.from_json(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        return Preferences()


def check(path: Path) -> None:
    """Raise ConfigError where something else than preferences lies at `path`: to keep them there would destroy it."""
    try:
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        told = json.loads(text) if text.strip() else {}
    except (OSError, ValueError):
        told = None
    if not isinstance(told, dict) or (told and "layers" not in told):
        raise ConfigError(f"{path} is no session of SplineScope and stays as it is: choose another name")


def save(preferences: Preferences, path: Path) -> None:
    """Keep them at `path`, whole or not at all. A place that cannot be written is logged and otherwise harmless."""
    draft = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.write_text(preferences.to_json() + "\n", encoding="utf-8")
        draft.replace(path)
    except OSError as error:
        log.warning("cannot remember the page's settings in %s: %s", path, error)
