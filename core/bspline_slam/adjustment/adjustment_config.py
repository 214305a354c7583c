"""What can be tuned of the adjustment."""

from __future__ import annotations

from dataclasses import dataclass

from bspline_slam.adjustment.trimming import TrimmingConfig


@dataclass(frozen=True, slots=True)
class AdjustmentConfig:
    """Rounds of foot points, the gate of each (m), and what keeps free directions in place.

    Beams farther off than `outlier` standard deviations count as if they were as noisy as that. `bend` is the standard
    deviation (m) of second differences of control points, `slide` that of a whole curve along itself as its best
    observer sees it: nothing measures that direction, so it only fixes the parametrisation. `anchor` holds the first
    pose (m, rad). `explained_weight` is the least share of a scan-matching factor that is kept: its beams already speak
    through the splines, but back ends that take key scans in their order begin where it says. Curves are trimmed every
    round. Half way the noise of the laser is estimated from what is left over (`estimate_noise`; else it is as
    configured), and knots that earn nothing are taken out; then and in the last round splines whose beams do not agree.
    """

    gates: tuple[float, ...] = (0.15, 0.1, 0.08, 0.08)
    outlier: float = 2.0
    bend: float = 0.5
    slide: float = 0.02
    anchor: float = 1e-5
    explained_weight: float = 0.02
    trimming: TrimmingConfig = TrimmingConfig()
    estimate_noise: bool = True
