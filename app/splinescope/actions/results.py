"""Actions on the results that were made of the log: which one is shown, which one is laid over it."""

from __future__ import annotations

from splinescope import commands as ask
from splinescope.actions.action import Action
from splinescope.comparison import largest_pose_difference
from splinescope.result import Result
from splinescope.session import Session

BUSY = "The estimator is at work; wait for its end, or cancel it."
ONLY_ONE = "There is no other result: run again under Estimate."
NONE_OVER = "No result is laid over the one shown: choose one under Compare."


def other(session: Session) -> Result | None:
    """The result after the one shown, in the order of their numbers, from the start again after the last."""
    results = session.results
    after = [result for result in results.all if results.shown is not None and result.number > results.shown.number]
    return next((result for result in (*after, *results.all) if result is not results.shown), None)


def over(session: Session) -> Result | None:
    """The result to lay over the one shown next: after the last one none."""
    results = session.results
    laid = results.compared.number if results.compared is not None else 0
    others = (result for result in results.all if result is not results.shown and result.number > laid)
    return next(others, None)


def _number(result: Result | None) -> int:
    return result.number if result is not None else 0


def _another(session: Session) -> str | None:
    return BUSY if session.busy else None if other(session) is not None else ONLY_ONE


def _laid(session: Session) -> str | None:
    return BUSY if session.busy else None if session.results.compared is not None else NONE_OVER


def _lay(session: Session) -> ask.Command:
    following = over(session)
    return ask.CompareWith(None if following is None else following.number)


def _farthest(session: Session) -> ask.Command:
    shown, compared = session.results.shown, session.results.compared
    most = largest_pose_difference(shown, compared) if shown is not None and compared is not None else None
    return ask.Seek(session.cursor if most is None else most.scan)


RESULTS = (
    Action("result-next", "Show the next result", (), lambda s: ask.ShowResult(_number(other(s))), _another),
    Action("result-over", "Lay the next result over it, or none", (), _lay, _another),
    Action(
        "result-swap",
        "Swap the result shown and the one over it",
        (),
        lambda session: ask.ShowResult(_number(session.results.compared)),
        _laid,
    ),
    Action("result-apart", "Go to where the two results differ most", (), _farthest, _laid),
    Action(
        "result-delete",
        "Delete the result over the one shown",
        (),
        lambda session: ask.DeleteResult(_number(session.results.compared)),
        _laid,
    ),
)
