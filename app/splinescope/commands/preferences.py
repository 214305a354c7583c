"""What is chosen for this and all later visits: layers, colours, theme, what the picture follows."""

from __future__ import annotations

from dataclasses import dataclass

from splinescope.view import Colouring, Layer


@dataclass(frozen=True, slots=True)
class SetLayer:
    """Show or hide one layer."""

    layer: Layer
    on: bool


@dataclass(frozen=True, slots=True)
class ToggleLayers:
    """Hide these layers if all of them are shown, show them otherwise."""

    layers: frozenset[Layer]


@dataclass(frozen=True, slots=True)
class SetColouring:
    """Colour the curves of the map by this."""

    colouring: Colouring


@dataclass(frozen=True, slots=True)
class NextColouring:
    """Colour the curves of the map by the thing `by` further on in the list."""

    by: int


@dataclass(frozen=True, slots=True)
class SetDark:
    """Dark or light page; None changes to the other one."""

    dark: bool | None = None


@dataclass(frozen=True, slots=True)
class FollowRobot:
    """Keep the robot in the middle of the picture."""

    on: bool


@dataclass(frozen=True, slots=True)
class RobotUp:
    """Turn the picture so that the robot drives upwards, or north up again; None changes to the other."""

    on: bool | None = None


@dataclass(frozen=True, slots=True)
class SeenTour:
    """Invite nobody to the guided tour any more."""


PreferenceCommand = SetLayer | ToggleLayers | SetColouring | NextColouring | SetDark | FollowRobot | RobotUp | SeenTour
