"""Buttons of actions side by side, as HTML: one that can do nothing now looks so, and its tooltip says why."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from splinescope import table
from splinescope.actions import ACTIONS
from splinescope.session import Session
from splinescope.table import Html

Buttons = Mapping[str, str]
"""What buttons say, and the actions that they ask for."""


def action_row(session: Session, buttons: Buttons, *, label: str = "", strong: str = "") -> Html:
    """Buttons in a row, behind a label where there is one; that of the action `strong` is the one to press."""
    name = f"<span>{escape(label)}</span>" if label else ""
    made = (button(session, words, action, action == strong) for words, action in buttons.items())
    return Html(f'<div class="acts">{name}<div>{"".join(made)}</div></div>')


def button(session: Session, words: str, action: str, strong: bool = False) -> Html:
    """One of them; pressed while it can do nothing, it says why as well, for fingers know no tooltips."""
    row = ACTIONS[action]
    refusal = row.refusal(session)
    key = f" ({row.shown})" if row.keys else ""
    kind = "act strong" if strong else "act"
    off = ' aria-disabled="true"' if refusal is not None else ""
    title = table.escaped(refusal or f"{row.words}{key}")
    return Html(f'<button class="{kind}" data-action="{escape(action)}" title="{title}"{off}>{escape(words)}</button>')
