"""Finished runs over one log: the latest are kept, one is shown, another may be laid over it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.edits.edit import Edit
from bspline_slam.lab.scan_consistency import ScanConsistency
from bspline_slam.lab.stretches import Stretches
from bspline_slam.slam import SlamStep, Snapshot
from splinescope.computing.iterations import Frame
from splinescope.computing.packed_result import PackedResult
from splinescope.computing.solution import Solution
from splinescope.quality import Quality
from splinescope.recipe import Recipe

KEPT = 6
"""So many results are kept, for each is as large as a map with all its decisions."""


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What one run gave: the map for looking at, the decisions, the figures.

    `origin` is the run over the log whose decisions were solved again, as it was then with its hand edits; None for
    such a run itself.
    `edits` are the hand edits that it has been amended by; `kept` has none of them, and `amended`, where it is there
    already, all of them.
    `stopped_after` counts the scans of a run that was cancelled. `kept` is the pickled whole snapshot, for the
    estimator; its quality, covariances of splines by id, 1σ across the curves
    and the tests of consistency are there once the result is `measured`. `frames` are iterations of its last solve.
    """

    number: int
    recipe: Recipe
    snapshot: Snapshot
    steps: Mapping[int, SlamStep]
    processed: int
    kept: bytes
    solution: Solution | None = None
    quality: Quality | None = None
    origin: Result | None = None
    stopped_after: int | None = None
    covariances: Mapping[int, Float[np.ndarray, "d d"]] = field(default_factory=dict)
    sigmas: Stretches | None = None
    frames: tuple[Frame, ...] = ()
    consistency: ScanConsistency | None = None
    measured: bool = False
    edits: tuple[Edit, ...] = ()
    amended: bytes | None = None

    @property
    def packed(self) -> PackedResult:
        """The whole of it, for the estimator."""
        return PackedResult(self.kept, self.recipe.config(), self.edits, self.amended)

    @property
    def editable(self) -> bool:
        """Whether it is a finished run, which hand edits can amend."""
        return self.origin is None and self.stopped_after is None and self.solution is not None

    @property
    def by_hand(self) -> int:
        """How many hand edits are in it."""
        return len(self.edits) if self.origin is None else len(self.origin.edits)

    @property
    def anees(self) -> float | None:
        """NEES of the key poses divided by its degrees of freedom; None while unknown, or without truth."""
        test = self.consistency.nees if self.consistency is not None else None
        return None if test is None or not len(test.squares) else float(test.squares.sum() / test.dof.sum())

    @property
    def label(self) -> str:
        """Number and choices in a few words."""
        ending = "" if self.stopped_after is None else " (stopped)"
        ending += f" + {self.by_hand} by hand" if self.by_hand else ""
        return f"{self.number}: {self.recipe.back_end}, {self.recipe.model}{ending}"


@dataclass(frozen=True, eq=False, slots=True)
class Results:
    """Results by number, which of them is shown and which compared with it, and how many there ever were."""

    all: tuple[Result, ...] = ()
    shown: Result | None = None
    compared: Result | None = None
    made: int = 0

    def find(self, number: int | None) -> Result | None:
        """The result of this number, None where there is none."""
        return next((result for result in self.all if result.number == number), None)

    def run_behind(self, result: Result) -> Result:
        """The run over the log behind a result, with the hand edits that it has now: where every other estimator
        starts, so that they can be compared."""
        return result if result.origin is None else self.find(result.origin.number) or result.origin

    def added(self, result: Result, show: bool = True) -> Results:
        """One more result; where it is shown, the one shown before is compared with it. The oldest that is not looked
        at falls out where they become too many."""
        more = replace(self, all=(*self.all, result), made=result.number)
        if show:
            more = replace(more, shown=result, compared=self.shown)
        old = (each for each in more.all if each not in (result, more.shown, more.compared))
        return more.without(next(old)) if len(more.all) > KEPT else more

    def showing(self, result: Result) -> Results:
        """Another result shown; where it was the compared one, the two change places."""
        return replace(self, shown=result, compared=self.shown if result is self.compared else self.compared)

    def comparing(self, result: Result | None) -> Results:
        """Another result compared, or none; nothing is compared with itself."""
        return replace(self, compared=None if result is self.shown else result)

    def without(self, result: Result) -> Results:
        """All but this one, which is not the one shown."""
        left = tuple(each for each in self.all if each is not result)
        return replace(self, all=left, compared=None if self.compared is result else self.compared)

    def updated(self, result: Result) -> Results:
        """The same with a newer value of the result of that number."""

        def newer(each: Result | None) -> Result | None:
            return result if each is not None and each.number == result.number else each

        changed = tuple(result if each.number == result.number else each for each in self.all)
        return replace(self, all=changed, shown=newer(self.shown), compared=newer(self.compared))
