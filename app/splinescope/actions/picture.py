"""Actions that change what is seen of the map, and how."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action, PageRequest, with_log
from splinescope.session import Session


def _robot(session: Session) -> ask.Command:
    return ask.FollowRobot(not session.preferences.follow_robot)


PICTURE = (
    Action("fit", "Show the whole map", ("f",), PageRequest.FIT),
    Action("fit-scan", "Zoom to the current scan", ("z",), PageRequest.FIT_SCAN, with_log),
    Action("look-there", "Zoom to what is selected", ("Z",), ask.LookThere(), with_log),
    Action("zoom-in", "Zoom in", ("+", "="), PageRequest.SCRIPT, repeats=True),
    Action("zoom-out", "Zoom out", ("-",), PageRequest.SCRIPT, repeats=True),
    Action("follow-robot", "Keep the robot in the middle, or let go", ("r",), _robot),
    Action("robot-up", "Robot up or north up", ("R",), ask.RobotUp()),
    Action("dark", "Dark or light page", ("d",), ask.SetDark()),
)
