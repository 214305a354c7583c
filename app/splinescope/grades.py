"""Residuals along curves in five grades, each with a colour of its own and a width of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.lab.stretches import Stretches


@dataclass(frozen=True, slots=True)
class Grade:
    """Root mean square distances up to `most` (m) that no grade before has: in words, and as a width in pixels."""

    label: str
    most: float
    width: float


GRADES = (
    Grade("up to 6 mm", 0.006, 1.6),
    Grade("6 to 9 mm", 0.009, 2.8),
    Grade("9 to 12 mm", 0.012, 4.0),
    Grade("12 to 18 mm", 0.018, 5.4),
    Grade("above 18 mm", float("inf"), 7.5),
)
UNKNOWN, UNGRADED = -1, "Too few beams"
"""Grade and label of a stretch that tells nothing."""


def graded(rms: Float[np.ndarray, "s"]) -> Int[np.ndarray, "s"]:
    """Which of GRADES each lies in; UNKNOWN where that is not known."""
    grade = np.searchsorted([grade.most for grade in GRADES], np.nan_to_num(rms))
    return np.where(np.isfinite(rms), grade, UNKNOWN)


def shares(stretches: Stretches) -> Float[np.ndarray, "grades"]:
    """Share of the graded stretches in each grade."""
    grade = graded(stretches.rms)
    counts = np.bincount(grade[grade >= 0], minlength=len(GRADES))
    return counts / max(counts.sum(), 1)


def stretches_of(stretches: Stretches, grade: int) -> list[tuple[int, tuple[float, float]]]:
    """Id of the spline and both ends (parameters) of all stretches of a grade, neighbours joined."""
    grades = graded(stretches.rms)
    cuts = (np.diff(grades) != 0) | (np.diff(stretches.spline) != 0)
    first = np.flatnonzero(np.concatenate([np.ones(len(grades[:1]), dtype=bool), cuts]))
    last = np.concatenate([first[1:] - 1, [len(grades) - 1]])[: len(first)]
    mine = grades[first] == grade
    return [
        (int(stretches.spline[a]), (float(stretches.start[a]), float(stretches.end[b])))
        for a, b in zip(first[mine], last[mine], strict=True)
    ]
