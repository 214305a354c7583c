"""What is looked at: selected, measured, taken apart, shown in pages."""

from __future__ import annotations

from dataclasses import dataclass

from bspline_slam.measuring import Picked
from splinescope.browser.link import Link
from splinescope.browser.values import Place
from splinescope.closures import ClosurePage
from splinescope.view import Selection


@dataclass(frozen=True, slots=True)
class Select:
    """Look at one thing; None looks at nothing."""

    selection: Selection | None


@dataclass(frozen=True, slots=True)
class Leave:
    """Step back out of what is being done: put the ruler away, else nothing is selected any more."""


@dataclass(frozen=True, slots=True)
class Measure:
    """Take the ruler out, lay it to what is selected, or put it away when that was all."""


@dataclass(frozen=True, slots=True)
class LayRuler:
    """Measure from or to this thing."""

    picked: Picked


@dataclass(frozen=True, slots=True)
class ShowIteration:
    """Show the map at the iteration kept under this number; None: the result."""

    number: int | None


@dataclass(frozen=True, slots=True)
class StepIteration:
    """Show the map `by` kept iterations further on."""

    by: int


@dataclass(frozen=True, slots=True)
class ShowClosure:
    """Go to the later scan of the loop closure of this number, and look at the closure."""

    number: int


@dataclass(frozen=True, slots=True)
class LeafThrough:
    """Show this page of the list of loop closures."""

    page: ClosurePage


@dataclass(frozen=True, slots=True)
class ShowObservation:
    """Open or close the window that takes one observation apart; None changes to the other."""

    on: bool | None = None


@dataclass(frozen=True, slots=True)
class StepObservation:
    """Show the step of the observation `by` further on; opens its window first."""

    by: int


@dataclass(frozen=True, slots=True)
class LookFrom:
    """The driver's page looks at this place; None: at the whole map."""

    place: Place | None


@dataclass(frozen=True, slots=True)
class LookThere:
    """Let the page that asks look at what is selected, or at the scan shown."""


@dataclass(frozen=True, slots=True)
class ShowTab:
    """The driver's page shows these tabs: their names with commas between them."""

    name: str


@dataclass(frozen=True, slots=True)
class FollowLink:
    """Show the moment that a link names, standing still; once a log is open."""

    link: Link


LookingCommand = (
    Select
    | Leave
    | Measure
    | LayRuler
    | ShowIteration
    | StepIteration
    | ShowClosure
    | LeafThrough
    | ShowObservation
    | StepObservation
    | LookFrom
    | LookThere
    | ShowTab
    | FollowLink
)
