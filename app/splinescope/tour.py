"""The guided tour: two minutes on the sample log, with one wrong association, how it is found, and how it is mended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from bspline_slam.edits.edit import Force
from splinescope import commands as ask
from splinescope.session import Session
from splinescope.view import Colouring, Layer, Selection

WAIT = "The log is still being read and adjusted: the tour goes on as soon as that is done."


@dataclass(frozen=True, slots=True)
class Step:
    """One card: what it says, the tab that goes with it, what it does when it comes up, when a person has done what it
    asks for (None: it asks for nothing), and the rows of a table that it speaks of."""

    title: str
    text: str
    tab: str = ""
    enter: Callable[[Session, Force], tuple[ask.Command, ...]] = lambda session, mistake: ()
    done: Callable[[Session, Force], bool] | None = None
    rows: str = ""


@dataclass(frozen=True, slots=True)
class Tour:
    """Which step is shown, and the mistake that the tour makes (None until there is a map to make it in)."""

    step: int = 0
    mistake: Force | None = None

    @property
    def shown(self) -> Step:
        return STEPS[self.step]

    def moved(self, by: int) -> Tour:
        """The step `by` further on, kept inside the tour."""
        return replace(self, step=min(max(self.step + by, 0), len(STEPS) - 1))


def _look_at(session: Session, mistake: Force) -> tuple[ask.Command, ...]:
    return (ask.Seek(mistake.scan), ask.Select(Selection("segment", mistake.segment)), ask.LookThere())


def _err(session: Session, mistake: Force) -> tuple[ask.Command, ...]:
    if erring(session, mistake):
        return _look_at(session, mistake)
    return (*_look_at(session, mistake), ask.ProposeEdits((mistake,)), ask.AcceptEdits())


def erring(session: Session, mistake: Force) -> bool:
    """Whether the mistake is in force."""
    return mistake in session.editing.history.active


def found(session: Session, mistake: Force) -> bool:
    """Whether the queue of doubts has led to the mistake."""
    doubt = session.editing.doubts.current
    return doubt is not None and doubt.piece is not None and (doubt.scan, doubt.piece.segment) == (
        mistake.scan, mistake.segment
    )  # fmt: skip


STEPS = (
    Step(
        "A map made of curves",
        "A robot drove through this office. Every stroke is one B-spline curve with a few control points; the thin "
        "line is where the robot drove, the dashed one where its wheels alone would have put it.",
        "layers",
        lambda session, mistake: (ask.Select(None), ask.Pause()),
    ),
    Step(
        "Step through the log",
        "Press → until the tour goes on. The arrow is the robot; its beams are cut into segments, and each "
        "segment is fitted with a curve.",
        "scan",
        lambda session, mistake: (ask.Select(None), ask.Pause(), ask.Seek(max(mistake.scan - 4, 0))),
        lambda session, mistake: session.cursor >= mistake.scan,
    ),
    Step(
        "Every decision can be asked",
        "This segment is selected. On the right you see which spline it was given to, how far it lies from it, how far "
        "it may lie (the gate), and the runner-up if there is one. J and K go to its neighbours.",
        "scan",
        _look_at,
    ),
    Step(
        "Now a wrong decision",
        "The tour has just forced this segment to another wall, as a hasty person might. The map answers at once; the "
        "exact optimum follows in the background.",
        "edit",
        _err,
    ),
    Step(
        "How it is found",
        "Doubtful decisions wait in a queue under Edit, the worst first. Press Q, or click the first row: it leads to "
        "the wrong one and says how far off it is. Curves are coloured by their residuals now, thick where beams do "
        "not fit.",
        "edit",
        lambda session, mistake: (
            ask.SetColouring(Colouring.RESIDUAL),
            ask.SetLayer(Layer.SPLINES, True),
            ask.Select(None),
        ),
        lambda session, mistake: found(session, mistake),
        "doubt",
    ),
    Step(
        "Mend it",
        "This is the place; the solver says under Edit whether it followed the edit or outvoted it. Press Ctrl + Z, or "
        "Undo. Nothing is lost: every edit stays in the history, and can be made again.",
        "edit",
        lambda session, mistake: (),
        lambda session, mistake: not erring(session, mistake),
    ),
    Step(
        "That is all",
        "An edit undone leaves the map as it was. Select any segment and overrule it; Ctrl + K finds every action by "
        "its name, and ? shows the keys.",
        "edit",
        lambda session, mistake: (ask.SetColouring(Colouring.SPLINE), ask.Select(None)),
    ),
)


def ready(session: Session) -> bool:
    """Whether there is a finished map that can be edited."""
    return session.result is not None and not session.busy and session.editing.refusal is None
