"""What commands about looks, and links, do to what a person has chosen."""

from __future__ import annotations

from dataclasses import replace

from splinescope import commands as ask
from splinescope.browser.link import Link
from splinescope.browser.preferences import Preferences
from splinescope.view import Colouring


def preferred(preferences: Preferences, command: ask.PreferenceCommand) -> Preferences:
    """The preferences after a command."""
    layers = preferences.layers
    match command:
        case ask.SetLayer(layer=layer, on=on):
            return replace(preferences, layers=layers | {layer} if on else layers - {layer})
        case ask.ToggleLayers(layers=group):
            return replace(preferences, layers=layers - group if group <= layers else layers | group)
        case ask.SetColouring(colouring=colouring):
            return replace(preferences, colouring=colouring)
        case ask.NextColouring(by=by):
            every = list(Colouring)
            return replace(preferences, colouring=every[(every.index(preferences.colouring) + by) % len(every)])
        case ask.SeenTour():
            return replace(preferences, toured=True)
        case ask.SetDark(dark=dark):
            return replace(preferences, dark=not preferences.dark if dark is None else dark)
        case ask.RobotUp(on=on):
            return replace(preferences, robot_up=not preferences.robot_up if on is None else on)
        case ask.FollowRobot(on=on):
            return replace(preferences, follow_robot=on)


def linked(preferences: Preferences, link: Link) -> Preferences:
    """The preferences with what a link asks for."""
    return replace(
        preferences,
        layers=preferences.layers if link.layers is None else link.layers,
        colouring=preferences.colouring if link.colouring is None else link.colouring,
    )
