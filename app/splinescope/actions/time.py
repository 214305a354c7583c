"""Actions of the timeline: play, step, speed."""

from __future__ import annotations

import math

from bspline_slam.errors import SplineSlamError
from splinescope import commands as ask
from splinescope.actions.action import Action, PageRequest, Question, with_log
from splinescope.session import Session


def _follow(session: Session) -> ask.Command:
    return ask.FollowProcessing(not session.following)


def _to_second(text: str) -> ask.Command:
    try:
        seconds = float(text.replace(",", ".").removesuffix("s"))
    except ValueError:
        seconds = math.nan
    if not math.isfinite(seconds):
        raise SplineSlamError(f"“{text}” is no number of seconds")
    return ask.SeekTime(seconds)


TIME = (
    Action("play", "Play or pause; at the end, from the start", (" ",), ask.TogglePlay(), with_log),
    Action("next-scan", "Forward 1 scan", ("ArrowRight", "."), ask.Step(1), with_log, repeats=True),
    Action("previous-scan", "Back 1 scan", ("ArrowLeft", ","), ask.Step(-1), with_log, repeats=True),
    Action("on-10", "Forward 10 scans", ("Shift+ArrowRight",), ask.Step(10), with_log, repeats=True),
    Action("back-10", "Back 10 scans", ("Shift+ArrowLeft",), ask.Step(-10), with_log, repeats=True),
    Action("first-scan", "First scan", ("Home",), ask.Seek(0), with_log),
    Action("last-scan", "Last scan", ("End",), ask.Seek(-1), with_log),
    Action("go-to-scan", "Go to a scan by its number", ("g",), PageRequest.SCRIPT, with_log),
    Action(
        "go-to-second",
        "Go to a second of the log",
        ("G",),
        PageRequest.ASK,
        with_log,
        asks=Question("Seconds since the first scan", _to_second, "42.5"),
    ),
    Action("faster", "Play faster", ("]",), ask.ChangeSpeed(1)),
    Action("slower", "Play slower", ("[",), ask.ChangeSpeed(-1)),
    Action("newest", "Show the newest processed scan, or let go", ("l",), _follow, with_log),
)
