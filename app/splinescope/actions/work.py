"""Actions of the estimator."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action
from splinescope.session import Session


def _idle(session: Session) -> str | None:
    return "Nothing is running." if session.activity is None and session.opening is None else None


WORK = (
    Action("run", "Run the whole log again", (), ask.RunAgain(), lambda session: session.run_refusal),
    Action("optimise", "Only solve this map again", ("o",), ask.Optimise(), lambda session: session.refusal),
    Action("cancel", "Cancel what is running", (), ask.Cancel(), _idle),
)
