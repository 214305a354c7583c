"""The search for a scan around what is known of its surroundings, where refinement alone is not to be believed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.front_end.match_information import turned
from bspline_slam.front_end.motion import surprise
from bspline_slam.front_end.scan_matching import (
    Match,
    MatchingConfig,
    PointSet,
    Surroundings,
    correlation,
    search,
    settle,
)
from bspline_slam.front_end.tracking_config import TrackingConfig

MARGIN = 0.05
"""By so much (correlation) a less likely guess must do better than a more likely one."""
ALIKE = 0.25
"""Search windows that lie apart by less than this share of their reach find the same."""


def searched(
    place: Surroundings,
    points: PointSet,
    previous: Float[np.ndarray, "3"],
    tries: Sequence[Float[np.ndarray, "3"]],
    information: Float[np.ndarray, "3 3"],
    refined: Float[np.ndarray, "3"] | None,
    tracking: TrackingConfig,
    matching: MatchingConfig,
) -> Match:
    """The best of searches around each guess of the step from the `previous` pose.

    Where no odometry tells of it, in a wider window, and wider still when nothing good is found; what is found must
    then do better than the pose `refined` without a search, for along a bare wall all poses are as good. What
    contradicts odometry that is believed (with this `information`) counts only where the scan were lost without it, for
    the last place is known better than the next.
    """
    if refined is not None:
        return _searched_wide(place, points, previous, tries, information, refined, tracking, matching)
    guess, best, best_score = previous, previous, -1.0
    for step in apart(tries, matching.reach, matching.turn):
        start = se2.compose(previous, step)
        found, score = search(place.field, points, start, matching, matching.reach, matching.turn)
        against = surprise(se2.between(tries[0], step), information) > tracking.wheel_gate
        if against and (best_score > tracking.lost_score or score < tracking.good_score):
            continue
        if score > best_score + MARGIN:
            best, guess, best_score = found, start, score
        if best_score > tracking.good_score:
            break
    return settle(place, points, best, best_score, matching, guess, turned(information, best[2]))


def _searched_wide(
    place: Surroundings,
    points: PointSet,
    previous: Float[np.ndarray, "3"],
    tries: Sequence[Float[np.ndarray, "3"]],
    information: Float[np.ndarray, "3 3"],
    refined: Float[np.ndarray, "3"],
    tracking: TrackingConfig,
    matching: MatchingConfig,
) -> Match:
    """The same where no odometry tells where to look."""
    best, best_score = refined, correlation(place.field, points, refined, matching)
    for step in apart(tries, matching.wide_reach, matching.wide_turn):
        start = se2.compose(previous, step)
        found, score = search(place.field, points, start, matching, matching.wide_reach, matching.wide_turn)
        best, best_score = (found, score) if score > best_score + MARGIN else (best, best_score)
    if best_score < tracking.good_score:
        found, score = search(place.field, points, previous, matching, matching.widest_reach, matching.widest_turn)
        best, best_score = (found, score) if score > best_score + 2.0 * MARGIN else (best, best_score)
    return settle(place, points, best, best_score, matching, best, turned(information, best[2]))


def apart(steps: Sequence[Float[np.ndarray, "3"]], reach: float, turn: float) -> list[Float[np.ndarray, "3"]]:
    """Only those steps whose search windows are not much the same as that of an earlier one."""
    chosen: list[Float[np.ndarray, "3"]] = []
    for step in steps:
        off = [np.abs(step - other) / (reach, reach, turn) for other in chosen]
        if all(away.max() > ALIKE for away in off):
            chosen.append(step)
    return chosen
