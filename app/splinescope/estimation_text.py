"""What is said of the estimator's work: why it cannot begin, and how it ended."""

from __future__ import annotations

from bspline_slam.errors import ConfigError, as_sentence
from bspline_slam.slam import Snapshot, check_names
from splinescope.activity import Activity, Work, counted, duration
from splinescope.computing.solution import Solution
from splinescope.notice import Notice
from splinescope.recipe import Recipe
from splinescope.result import Results

AT_WORK = "The estimator is at work; wait for its end, or cancel it."
UNCHANGED = "The map stands as it was before."


def unfit(recipe: Recipe) -> str | None:
    """A sentence on why no log can be run with these choices; None where one can."""
    try:
        check_names(recipe.config())
    except ConfigError as error:
        return as_sentence(str(error))
    return None


def unsolvable(results: Results, recipe: Recipe) -> str | None:
    """A sentence on why the map shown cannot be solved with these choices; None where it can."""
    shown = results.shown
    if shown is None or not len(shown.snapshot.key_scans):
        return "There is no map yet."
    if recipe.back_end == "bs_slam" and results.run_behind(shown).edits:
        return "BS-SLAM measures along single beams, and hand edits tie whole pieces: choose another estimator."
    if not recipe.same_map(shown.recipe):
        return "Another model, order or other knots shape the map from its first scan on: run the whole log again."
    return None


def by_hand_in_words(edits: int) -> str:
    """So many edits."""
    return "one hand edit" if edits == 1 else f"{edits} hand edits"


def done(activity: Activity, snapshot: Snapshot, solution: Solution | None, edits: int = 0) -> Notice:
    """What to say at the end of a job."""
    if activity.work is Work.OPTIMISING and solution is not None:
        by_hand = f" with its {by_hand_in_words(edits)}" if edits else ""
        return Notice(
            f"The map is optimised{by_hand}",
            f"Cost {solution.cost_before:,.1f} → {solution.cost_after:,.1f}; "
            f"the largest move of a pose was {1000 * solution.largest_move:.1f} mm.",
        )
    time_taken = f" in {duration(solution.seconds)}" if solution is not None else ""
    scans, splines = counted(len(snapshot.poses), "scan"), counted(len(snapshot.map), "spline")
    return Notice("The log is processed", f"{scans} gave {splines}{time_taken}.")
