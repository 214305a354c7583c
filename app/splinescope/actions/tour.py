"""Actions of the guided tour."""

from __future__ import annotations

from splinescope.actions.action import Action, PageRequest

TOUR = (
    Action("tour", "Take the two-minute tour", (), PageRequest.TOUR),
    Action("tour-next", "Tour: go on", (), PageRequest.TOUR),
    Action("tour-back", "Tour: go back", (), PageRequest.TOUR),
    Action("tour-end", "End the tour", (), PageRequest.TOUR),
)
