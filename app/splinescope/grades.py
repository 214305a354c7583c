"""What curves are coloured by, in five grades, each with a colour of its own and a width of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.lab.stretches import Stretches
from splinescope.view import Colouring, MapView

WIDTHS = (1.6, 2.8, 4.0, 5.4, 7.5)
"""Of the lines of each grade, in pixels: no grade is told by its colour alone."""
UNKNOWN = -1
"""Grade of what cannot be told."""
Piece = tuple[int, tuple[float, float]]
"""Id of a spline, and both ends (parameters) of a stretch of it."""


@dataclass(frozen=True, slots=True)
class Scale:
    """A title with its unit, for each grade the largest value that it holds and its words, and the words for UNKNOWN
    (empty where everything is known)."""

    title: str
    most: tuple[float, ...]
    labels: tuple[str, ...]
    unknown: str = ""

    def graded(self, values: Float[np.ndarray, "s"]) -> Int[np.ndarray, "s"]:
        """Which grade each lies in; UNKNOWN where the value is not known."""
        grade = np.minimum(np.searchsorted(self.most, np.nan_to_num(values)), len(WIDTHS) - 1)
        return np.where(np.isfinite(values), grade, UNKNOWN)


def stepped(title: str, edges: Sequence[float], unit: str, scale: float, unknown: str = "") -> Scale:
    """A scale with these four edges; `scale` turns them into the unit of the labels."""
    shown = [f"{scale * edge:g}" for edge in edges]
    middle = (f"{low} to {high} {unit}" for low, high in pairwise(shown))
    labels = (f"up to {shown[0]} {unit}", *middle, f"above {shown[-1]} {unit}")
    return Scale(title, (*edges, np.inf), labels, unknown)


RESIDUALS = stepped("Residuals along curves, RMS", (0.006, 0.009, 0.012, 0.018), "mm", 1000.0, "Too few beams")
OBSERVATIONS = Scale(
    "Observations of a spline, key scans",
    (2, 5, 12, 30, np.inf),
    ("1 or 2", "3 to 5", "6 to 12", "13 to 30", "more than 30"),
)


SIGMAS = (5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 0.2, 0.5, 1.0)
"""Round uncertainties (m) that grades may begin at."""


def uncertainties(values: Float[np.ndarray, "s"]) -> Scale:
    """1σ across curves, in grades around that of the median: it grows with the way from where a drive began, so that
    those of one building would all lie in one grade of another. Round edges stay where they are under small edits."""
    known = values[np.isfinite(values)]
    middle = int(np.searchsorted(SIGMAS, np.median(known))) if len(known) else 2
    first = min(max(middle - 2, 0), len(SIGMAS) - 4)
    edges = SIGMAS[first : first + 4]
    return stepped("Uncertainty across curves, 1σ", edges, "mm", 1000.0, "Not known")


def ages(duration: float) -> Scale:
    """When splines were first seen: fifths of a log of this duration (s), so that no edit moves them."""
    unit, seconds = ("min", 60.0) if duration >= 300.0 else ("s", 1.0)
    edges = duration * np.arange(6) / 5
    shown = [f"{edge / seconds:.0f}" for edge in edges]
    labels = tuple(f"{low} to {high} {unit}" for low, high in pairwise(shown))
    return Scale(f"First seen, {unit} of the log", (*edges[1:-1].tolist(), np.inf), labels)


def scale_of(view: MapView | None, colouring: Colouring) -> Scale | None:
    """The scale that the curves of a map are coloured by; None where each has its own colour, also while nothing is
    known of what is asked for."""
    if view is None:
        return None
    match colouring:
        case Colouring.RESIDUAL if view.stretches is not None:
            return RESIDUALS
        case Colouring.UNCERTAINTY if view.sigmas is not None:
            return uncertainties(view.sigmas.value)
        case Colouring.OBSERVATIONS:
            return OBSERVATIONS
        case Colouring.AGE if view.times is not None and len(view.times) > 1:
            return ages(float(view.times[-1] - view.times[0]))
    return None


def pieces(view: MapView, colouring: Colouring, grade: int) -> list[Piece]:
    """All stretches of curve that have this grade, neighbours joined."""
    scale = scale_of(view, colouring)
    if scale is None:
        return []
    match colouring:
        case Colouring.RESIDUAL if view.stretches is not None:
            return stretches_of(view.stretches, scale, grade)
        case Colouring.UNCERTAINTY if view.sigmas is not None:
            return stretches_of(view.sigmas, scale, grade)
    grades = scale.graded(_values(view, colouring))
    return [(spline.id, spline.span) for spline, mine in zip(view.map, grades, strict=True) if mine == grade]


def _values(view: MapView, colouring: Colouring) -> Float[np.ndarray, "splines"]:
    if colouring is Colouring.AGE and view.times is not None:
        born = np.array([spline.born for spline in view.map], dtype=int)
        return view.times[np.clip(born, 0, len(view.times) - 1)] - view.times[0]
    return np.array([float(spline.observations) for spline in view.map])


def shares(stretches: Stretches, scale: Scale) -> Float[np.ndarray, "grades"]:
    """Share of the graded stretches in each grade."""
    grade = scale.graded(stretches.value)
    counts = np.bincount(grade[grade >= 0], minlength=len(WIDTHS))
    return counts / max(counts.sum(), 1)


def stretches_of(stretches: Stretches, scale: Scale, grade: int) -> list[Piece]:
    """All stretches of a grade, neighbours joined."""
    grades = scale.graded(stretches.value)
    cuts = (np.diff(grades) != 0) | (np.diff(stretches.spline) != 0)
    first = np.flatnonzero(np.concatenate([np.ones(len(grades[:1]), dtype=bool), cuts]))
    last = np.concatenate([first[1:] - 1, [len(grades) - 1]])[: len(first)]
    mine = grades[first] == grade
    return [
        (int(stretches.spline[a]), (float(stretches.start[a]), float(stretches.end[b])))
        for a, b in zip(first[mine], last[mine], strict=True)
    ]
