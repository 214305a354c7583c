"""The estimator's work, and its results."""

from __future__ import annotations

from dataclasses import dataclass

from splinescope.recipe import Recipe


@dataclass(frozen=True, slots=True)
class Choose:
    """Run with this model, estimator, order and knots from now on."""

    recipe: Recipe


@dataclass(frozen=True, slots=True)
class RunAgain:
    """Run over the whole log with the choices made."""


@dataclass(frozen=True, slots=True)
class Optimise:
    """Solve the map shown with the chosen back end."""


@dataclass(frozen=True, slots=True)
class ShowResult:
    """Show the result of this number."""

    number: int


@dataclass(frozen=True, slots=True)
class CompareWith:
    """Lay the result of this number over the one shown; None for none."""

    number: int | None


@dataclass(frozen=True, slots=True)
class DeleteResult:
    """Forget the result of this number."""

    number: int


@dataclass(frozen=True, slots=True)
class Cancel:
    """Stop what the estimator is doing; what it has done stays."""


WorkCommand = Choose | RunAgain | Optimise | ShowResult | CompareWith | DeleteResult | Cancel
