"""What stands in the middle while there is no map: that no log is open, that one is opening, or what failed."""

from __future__ import annotations

from dataclasses import dataclass

from splinescope.session import Session

EMPTY = "Choose a log under Log, on the left, or begin with the sample: a drive through a simulated office."


@dataclass(frozen=True, slots=True)
class Stage:
    """A title and a sentence; `kind` is "empty", "loading" or "error"; `action` is offered as a button."""

    kind: str
    title: str
    text: str
    action: str = ""


def stage_of(session: Session) -> Stage | None:
    """What to say instead of a map; None where there is something to see."""
    log = session.log
    if session.opening is not None and log is None:
        name = session.opening.title or session.opening.path.name
        return Stage("loading", f"Opening {name}…", "A log is read from its beginning to its end first.")
    if log is None and session.troubles:
        return Stage("error", "No log is open", session.troubles[-1], "open-sample")
    if log is None:
        return Stage("empty", "No log is open", EMPTY, "open-sample")
    if not len(log):
        return Stage("error", "This log holds no scans", "There is nothing to map: open another log under Log.")
    return None
