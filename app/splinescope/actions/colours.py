"""Actions that choose what the curves of the map are coloured by."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action
from splinescope.view import Colouring

COLOURS = (
    Action("colour-next", "Colour the curves by the next thing", ("c",), ask.NextColouring(1)),
    Action("colour-previous", "Colour the curves by the thing before", ("C",), ask.NextColouring(-1)),
    *(
        Action(f"colour-{each.name.lower()}", f"Colour the curves by {each.value}", (), ask.SetColouring(each))
        for each in Colouring
    ),
)
