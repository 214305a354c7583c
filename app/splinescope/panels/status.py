"""The head of the side bar: which log is open, what the estimator does, what went wrong."""

from __future__ import annotations

from html import escape

import viser

from splinescope import table
from splinescope.activity import Activity, Work, counted, duration
from splinescope.panels.action_row import button
from splinescope.panels.panel import Post
from splinescope.session import Session

WHAT_HAPPENS = "Each scan is cut into segments; the curves fitted to them are tied to curves of the map, which grows."


class StatusPanel:
    """Always in sight: the name of the log, the running job with its progress, and Cancel."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._text = gui.add_html(table.block(table.paragraph("Opening a log…")))

    def refresh(self, session: Session) -> None:
        self._text.content = table.block(*headline(session), *map(trouble, session.troubles))


def headline(session: Session) -> list[str]:
    """The log and the job, as HTML parts; as tall with a job beside the map as without."""
    activity, opening = session.activity, session.opening
    if activity is None and opening is None and session.log is None:
        return [table.paragraph("No log is open. Choose one under Log.")]
    busy = activity is not None or opening is not None
    parts = [head(session, busy), meter(activity.fraction if activity is not None else None, busy)]
    if opening is None and activity is not None and activity.work is Work.PROCESSING:
        parts += [table.paragraph(WHAT_HAPPENS, "dim"), table.paragraph(adjusted(activity), "dim")]
    return parts


def head(session: Session, busy: bool) -> str:
    """The name of the log, and what is being done with a button that ends it, in one row."""
    name = f"<b>{escape(session.title)}</b>" if session.log is not None else ""
    job = f"<span>{table.escaped(in_brief(session))}</span>{button(session, 'Cancel', 'cancel')}" if busy else ""
    return f'<div class="head">{name}{job}</div>'


def meter(fraction: float | None, busy: bool) -> str:
    """How far a job is, as a thin line: all of it where that is not known, none of it without a job."""
    done = 100.0 * (1.0 if fraction is None else fraction) if busy else 0.0
    return f'<div class="meter"><i style="width:{done:.0f}%"></i></div>'


def status_line(session: Session) -> str:
    """What goes on, or what there is, in one line."""
    if session.opening is not None:
        return f"Opening {session.opening.title or session.opening.path.name}…"
    if session.activity is not None:
        return doing(session)
    if session.log is None:
        return "No log is open."
    return summary(session)


def doing(session: Session) -> str:
    """What the estimator does, how far it is, and how long it still takes."""
    activity = session.activity
    if activity is None:
        return "The estimator is idle."
    text = activity.stage
    if activity.fraction is not None:
        text += f" · {100 * activity.fraction:.0f} %"
    if activity.seconds_left is not None:
        text += f" · {duration(activity.seconds_left)} left"
    return text


def in_brief(session: Session) -> str:
    """The same beside the name of the log: the line below the timeline says it in full."""
    activity = session.activity
    if session.opening is not None or activity is None:
        return status_line(session)
    if activity.fraction is None:
        return activity.stage.partition(" (")[0]
    left = "" if activity.seconds_left is None else f" · {duration(activity.seconds_left)} left"
    return f"{100 * activity.fraction:.0f} %{left}"


def adjusted(activity: Activity) -> str:
    """How much of the map that grows is the estimate, and not the front end's guess."""
    if not activity.adjusted:
        return "Not adjusted yet: the map is as scans were matched."
    return f"Adjusted up to scan {activity.adjusted - 1:,}; what was read since goes along."


def summary(session: Session) -> str:
    """The map in one line."""
    snapshot = session.findings.snapshot
    if snapshot is None:
        return "There is no map yet."
    accepted = sum(loop.accepted for loop in snapshot.loop_closures)
    parts = (
        counted(len(snapshot.map), "spline"),
        counted(snapshot.map.control_point_count, "control point"),
        counted(len(snapshot.key_scans), "key scan"),
        counted(accepted, "loop closure"),
    )
    return f"{', '.join(parts)}."


def trouble(sentence: str) -> str:
    """A sentence about what went wrong, as HTML."""
    return table.paragraph(sentence, "bad")
