"""Verdicts on matches with earlier places."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.front_end.loop_closure import LoopConfig, judge
from bspline_slam.front_end.scan_matching import Match


@pytest.mark.parametrize(("score", "inliers", "accepted"), [(0.8, 0.9, True), (0.3, 0.9, False), (0.8, 0.2, False)])
def test_verdicts(score: float, inliers: float, accepted: bool) -> None:
    verdict, reason = judge(Match(np.zeros(3), score, inliers, 0.01, np.eye(3)), LoopConfig())
    assert verdict is accepted
    assert reason
