"""What can be tuned of tracking."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class TrackingConfig:
    """When a scan becomes a key scan (m, rad), what it is matched to, and when its match is not believed.

    `local_scans` make the local map. A scan stands still, and is not matched, when odometry says so since the last
    matched one and at least `still_beams` of its ranges are within `still_range` (m) of that one's. A scan is searched
    for, not only refined, when fewer than `doubtful_inliers` of its beams fit, `unsure_inliers` where it lies `far_…`
    from the last one, or when the squared Mahalanobis distance to its prediction exceeds `surprise`; where no odometry
    is to be believed also when a direction is left open by more than `open_distance` (m, 1 σ) or fewer than
    `unsure_inliers` fit.
    Below a correlation of `lost_score`, or when less than `lost_beams` of its beams
    come back, a scan is lost and odometry is taken instead. When less than that see beyond `blocked_range` (m),
    somebody may stand before the laser, which fits anywhere: then a scan is lost too, unless there is no odometry to be
    believed and it fits where it is expected; and nothing is ever matched to it.
    `widening` multiplies the information of a match and `floor` adds to its standard deviations: neighbouring
    matches share their errors. A key scan that neither beams nor odometry tie to the one before, in any direction, lies
    within `lost_step` (m, m, rad; 1 σ) of it, and `lost_travel` is how far (m) each lost key scan counts as travelled;
    `untied` (m, rad; 1 σ) is between two of which neither knows of the other. A lost scan is taken to be of another
    place when walls were expected in `least_known` of the sectors in which its beams end, and it sees less than
    `least_agreeing` of them. Where no odometry is to be believed, the last of `patience` scans lost in a row becomes a
    key scan wherever it lies, or a robot that stands in a new place would stay lost.
    """

    distance: float = 0.5
    turn: float = np.deg2rad(20.0)
    local_scans: int = 12
    still_distance: float = 0.01
    still_turn: float = np.deg2rad(0.3)
    still_range: float = 0.05
    still_beams: float = 0.7
    far_distance: float = 0.35
    far_turn: float = np.deg2rad(15.0)
    good_score: float = 0.6
    lost_score: float = 0.3
    lost_beams: float = 0.1
    blocked_range: float = 0.6
    doubtful_inliers: float = 0.5
    surprise: float = 9.0
    open_distance: float = 0.03
    unsure_inliers: float = 0.7
    widening: float = 9.0
    wheel_gate: float = 25.0
    floor: tuple[float, float, float] = (0.007, 0.007, 0.003)
    lost_step: tuple[float, float, float] = (1.0, 1.0, 0.5)
    lost_travel: float = 10.0
    least_known: float = 0.5
    least_agreeing: float = 0.35
    untied: float = 1e3
    patience: int = 10
