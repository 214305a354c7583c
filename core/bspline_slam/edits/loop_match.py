"""Two key scans held against each other: how they lie, found from a coarse guess, and how well they agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.edits.decisions import Decisions
from bspline_slam.front_end.growth import left_normals
from bspline_slam.front_end.loop_closure import judge
from bspline_slam.front_end.match_information import matched_information
from bspline_slam.front_end.scan_matching import PointSet, find_with_icp
from bspline_slam.graph import square_root
from bspline_slam.sights import KeyObservations
from bspline_slam.slam import SlamConfig

REACH, TURN = 0.6, np.deg2rad(15.0)
"""How far (m, rad) from the guess is searched."""


@dataclass(frozen=True, eq=False, slots=True)
class LoopMatch:
    """How a key scan lies as seen from an earlier one, how sure that is, the correlation (0…1), the share of beams on
    the earlier map, and whether a closure would be accepted by the rule, with its sentence."""

    measured: Float[np.ndarray, "3"]
    sqrt_information: Float[np.ndarray, "3 3"]
    score: float
    inliers: float
    acceptable: bool
    sentence: str


def match_loop(
    decisions: Decisions, earlier: int, scan: int, guess: Float[np.ndarray, "3"], config: SlamConfig
) -> LoopMatch:
    """Match key scan `scan` to the surroundings of the key scan `earlier`, from `guess`, its pose as seen from there.

    Raises EditError where one of them is no key scan.
    """
    i, j = decisions.number(earlier), decisions.number(scan)
    near = [
        k
        for k in range(max(i - config.loops.half_width, 0), min(i + config.loops.half_width + 1, len(decisions.keys)))
        if k != j
    ]
    places, mine = [point_set(decisions.keys[k]) for k in near], point_set(decisions.keys[j])
    start = se2.compose(decisions.poses[i], guess)
    match = find_with_icp(places, decisions.poses[near], mine, start, config.matching, REACH, TURN)
    acceptable, sentence = judge(match, config.loops)
    root = square_root(matched_information(match, config.tracking) + 1e-6 * np.eye(3))
    measured = se2.between(decisions.poses[i], match.pose)
    return LoopMatch(measured, root, match.score, match.inliers, acceptable, sentence)


def point_set(key: KeyObservations) -> PointSet:
    """The beam ends of a key scan's segments with their normals."""
    points = np.concatenate([np.zeros((0, 2)), *(segment.points for segment in key.segments)])
    sizes = np.array([len(segment.points) for segment in key.segments], dtype=np.int64)
    return PointSet(points, left_normals(points, sizes))
