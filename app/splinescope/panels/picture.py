"""The picture: theme, fit, following the robot, help."""

from __future__ import annotations

import viser

from splinescope.commands import FollowRobot, SetDark
from splinescope.keys import PageAction
from splinescope.panels.panel import Post, on_change, on_press
from splinescope.session import Session


class PicturePanel:
    """How the page looks, for everybody who looks at it."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        on_press(gui.add_button("Show the whole map", hint="Key f"), lambda: post(PageAction.FIT))
        self._robot = gui.add_checkbox("Keep the robot in the middle", initial_value=False)
        self._dark = gui.add_checkbox("Dark page", initial_value=True)
        on_press(gui.add_button("Keys and help", hint="Key ?"), lambda: post(PageAction.HELP))
        on_change(self._robot, lambda: post(FollowRobot(self._robot.value)))
        on_change(self._dark, lambda: post(SetDark(self._dark.value)))

    def refresh(self, session: Session) -> None:
        self._robot.value = session.preferences.follow_robot
        self._dark.value = session.preferences.dark
