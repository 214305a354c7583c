"""Actions of the estimator."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from bspline_slam.backends import BACK_ENDS
from bspline_slam.observation import MODELS
from splinescope import commands as ask
from splinescope.actions.action import Action, PageRequest, Question
from splinescope.paths import SAMPLE, find_log, sample_logs
from splinescope.session import Session


def _idle(session: Session) -> str | None:
    return "Nothing is running." if session.activity is None and session.opening is None else None


def _sample(session: Session) -> ask.Command:
    return ask.OpenLog(find_log(SAMPLE))


def _choice(field: str, value: str, session: Session) -> ask.Command:
    return ask.Choose(replace(session.recipe, **{field: value}))


def _unsolved(session: Session) -> str | None:
    return None if len(session.frames) > 1 else "There is no solve whose iterations could be shown."


WORK = (
    Action(
        "open-log",
        "Open a log",
        ("O",),
        PageRequest.ASK,
        asks=Question(
            "A file or folder on the computer that runs SplineScope, or a sample by its name",
            lambda text: ask.OpenLog(find_log(text)),
            "~/logs/corridor.mcap",
            tuple(sample_logs()),
        ),
    ),
    Action("open-sample", "Open the sample log", (), _sample),
    Action("run", "Run the whole log again", (), ask.RunAgain(), lambda session: session.run_refusal),
    Action("optimise", "Only solve this map again", ("o",), ask.Optimise(), lambda session: session.refusal),
    Action("iteration-next", "Next iteration of the solve", (">",), ask.StepIteration(1), _unsolved, repeats=True),
    Action("iteration-back", "Iteration before", ("<",), ask.StepIteration(-1), _unsolved, repeats=True),
    Action("iteration-result", "Back to the result of the solve", (), ask.ShowIteration(None), _unsolved),
    *(
        Action(f"model-{model}", f"Model of the next run: {model}", (), partial(_choice, "model", model))
        for model in MODELS
    ),
    *(
        Action(f"estimator-{name}", f"Estimator of the next run: {name}", (), partial(_choice, "back_end", name))
        for name in BACK_ENDS
    ),
    Action("cancel", "Cancel what is running", (), ask.Cancel(), _idle),
)
