"""What every panel is: widgets made once, shown anew from the session, asking by commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import viser

from splinescope.actions import Perform
from splinescope.browser.asker import asked_by
from splinescope.commands import Command
from splinescope.session import Session

Post = Callable[[Command | Perform], None]
"""Hands a request to the owner of the session; callable from any thread."""


class Panel(Protocol):
    """A group of widgets; `refresh` is called by the owner of the session after something changed."""

    def refresh(self, session: Session) -> None: ...


def on_press(button: viser.GuiButtonHandle, act: Callable[[], None]) -> None:
    """Call `act` when a person presses the button."""

    @button.on_click
    def _(event: viser.GuiEvent) -> None:
        if event.client is not None:
            with asked_by(event.client.client_id):
                act()


def on_choice(group: viser.GuiButtonGroupHandle, act: Callable[[str], None]) -> None:
    """Call `act` with the button of a group that a person presses."""

    @group.on_click
    def _(event: viser.GuiEvent) -> None:
        if event.client is not None:
            with asked_by(event.client.client_id):
                act(event.target.value)


def on_change(widget: viser.GuiInputHandle, act: Callable[[], None]) -> None:
    """Call `act` when a person changes the widget, not when the session does."""

    @widget.on_update
    def _(event: viser.GuiEvent) -> None:
        if event.client is not None:
            with asked_by(event.client.client_id):
                act()
