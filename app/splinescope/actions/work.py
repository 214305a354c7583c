"""Actions of the estimator."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action
from splinescope.paths import SAMPLE, find_log
from splinescope.session import Session


def _idle(session: Session) -> str | None:
    return "Nothing is running." if session.activity is None and session.opening is None else None


def _sample(session: Session) -> ask.Command:
    return ask.OpenLog(find_log(SAMPLE))


def _unsolved(session: Session) -> str | None:
    return None if len(session.frames) > 1 else "There is no solve whose iterations could be shown."


WORK = (
    Action("open-sample", "Open the sample log", (), _sample),
    Action("run", "Run the whole log again", (), ask.RunAgain(), lambda session: session.run_refusal),
    Action("optimise", "Only solve this map again", ("o",), ask.Optimise(), lambda session: session.refusal),
    Action("iteration-next", "Next iteration of the solve", (">",), ask.StepIteration(1), _unsolved, repeats=True),
    Action("iteration-back", "Iteration before", ("<",), ask.StepIteration(-1), _unsolved, repeats=True),
    Action("iteration-result", "Back to the result of the solve", (), ask.ShowIteration(None), _unsolved),
    Action("cancel", "Cancel what is running", (), ask.Cancel(), _idle),
)
