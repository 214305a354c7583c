"""The picture: theme, fit, following the robot, help."""

from __future__ import annotations

import viser

from splinescope import table
from splinescope.commands import FollowRobot, RobotUp, SetDark
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post, on_change
from splinescope.session import Session

WAYS: Buttons = {
    "Whole map": "fit",
    "This scan": "fit-scan",
    "Copy a link": "copy-link",
    "Find an action": "palette",
    "Keys and help": "help",
    "Tour": "tour",
}


class PicturePanel:
    """How the page looks, for everybody who looks at it."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._robot = gui.add_checkbox("Keep the robot in the middle", initial_value=False)
        self._up = gui.add_checkbox("Robot up, not north up", initial_value=False, hint="Key Shift + R")
        self._dark = gui.add_checkbox("Dark page", initial_value=True)
        self._ways = gui.add_html("")
        on_change(self._robot, lambda: post(FollowRobot(self._robot.value)))
        on_change(self._up, lambda: post(RobotUp(self._up.value)))
        on_change(self._dark, lambda: post(SetDark(self._dark.value)))

    def refresh(self, session: Session) -> None:
        self._ways.content = table.block(action_row(session, WAYS))
        self._robot.value = session.preferences.follow_robot
        self._up.value = session.preferences.robot_up
        self._dark.value = session.preferences.dark
