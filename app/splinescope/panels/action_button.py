"""A button for an action: its words, its key, and the reason why it cannot be pressed come from the table."""

from __future__ import annotations

from typing import Literal

import viser

from splinescope.actions import ACTIONS, Perform
from splinescope.panels.panel import Post, on_press
from splinescope.session import Session


class ActionButton:
    """One button; `words` replaces those of the table where the place says the rest."""

    def __init__(
        self,
        gui: viser.GuiApi,
        post: Post,
        action: str,
        *,
        words: str | None = None,
        icon: viser.IconName | None = None,
        color: Literal["gray"] | None = None,
    ) -> None:
        self._action = ACTIONS[action]
        self._key = f"Key {self._action.shown}" if self._action.keys else None
        self.handle = gui.add_button(words or self._action.words, icon=icon, color=color, hint=self._key)
        on_press(self.handle, lambda: post(Perform(action)))

    def refresh(self, session: Session) -> None:
        """Press-able or not, and why not."""
        refusal = self._action.refusal(session)
        self.handle.disabled, self.handle.hint = refusal is not None, refusal or self._key
