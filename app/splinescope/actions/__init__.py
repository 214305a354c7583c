"""The one table of actions: buttons, keys, the palette and the help sheet are all made of it.

To add an action, put an `Action` into one of the groups beside this file (or a group of its own into `GROUPS`); its
key, its place in palette and help sheet, and its refusal follow. A button for it is
`ActionButton(gui, post, id)`, and buttons side by side are an `action_row`.
"""

from __future__ import annotations

from splinescope.actions.action import Action, Answer, PageRequest, Perform, Question, Request
from splinescope.actions.colours import COLOURS
from splinescope.actions.editing import EDITING, FINDING, GHOST
from splinescope.actions.layers import GROUPS as LAYER_GROUPS
from splinescope.actions.layers import SINGLE
from splinescope.actions.looking import LOOKING
from splinescope.actions.page import PAGE
from splinescope.actions.picture import PICTURE
from splinescope.actions.quality import QUALITY
from splinescope.actions.results import RESULTS
from splinescope.actions.time import TIME
from splinescope.actions.tour import TOUR
from splinescope.actions.work import WORK
from splinescope.session import Session

__all__ = [
    "ACTIONS",
    "GROUPS",
    "Action",
    "Answer",
    "PageRequest",
    "Perform",
    "Question",
    "Request",
    "described",
    "find",
    "refusals",
]

GROUPS: dict[str, tuple[Action, ...]] = {
    "Time": TIME,
    "Looking closer": LOOKING,
    "Editing": EDITING,
    "Closing a loop": GHOST,
    "Finding": FINDING,
    "Picture": PICTURE,
    "Layers": LAYER_GROUPS,
    "Single layers": SINGLE,
    "Colours": COLOURS,
    "Estimator": WORK,
    "Results": RESULTS,
    "Quality": QUALITY,
    "Page": PAGE,
    "Tour": TOUR,
}
"""All actions under the headings of the help sheet."""

ACTIONS = {action.id: action for group in GROUPS.values() for action in group}
"""All actions by id."""

ABOUT = (
    "A laser log is read scan by scan. Each scan is cut into segments, each segment is fitted with a B-spline curve, "
    "and each curve is either matched to a curve of the map or starts a new one. The map is these curves.",
    "Drag to move the map, turn the wheel to zoom, click a thing to learn what it is.",
)


def find(action: str) -> Action | None:
    """The action of this id; None where there is none."""
    return ACTIONS.get(action)


def described() -> dict[str, object]:
    """The table for the script of the page: `about`, sentences for the help sheet, and `actions`."""
    rows = [
        {
            "id": action.id,
            "words": action.words,
            "keys": action.keys,
            "shown": action.shown,
            "group": title,
            "repeats": action.repeats,
            "script": action.does is PageRequest.SCRIPT,
            "asks": asked(action),
        }
        for title, group in GROUPS.items()
        for action in group
    ]
    return {"about": ABOUT, "actions": rows}


def asked(action: Action) -> dict[str, object] | None:
    """The question of an action for the script of the page."""
    question = action.asks
    if question is None:
        return None
    return {"label": question.label, "example": question.example, "choices": question.choices}


def refusals(session: Session) -> dict[str, str]:
    """Why actions cannot be done now, by id; those that can be done are missing."""
    return {action.id: refusal for action in ACTIONS.values() if (refusal := action.refusal(session)) is not None}
