"""Support is counted as by hand."""

import numpy as np
import pytest

from bspline_slam.kernels.support import support


@pytest.mark.parametrize("nearby", [0, 1, 2])
def test_different_poses_within_reach_are_counted(nearby: int) -> None:
    rng = np.random.default_rng(nearby)
    cell = np.sort(rng.integers(0, 40, 120))
    pose = rng.integers(0, 9, 120)
    wanted = [len(set(pose[np.abs(cell - here) <= nearby])) for here in cell]
    assert support(cell, pose, nearby).tolist() == wanted


def test_one_beam_supports_itself() -> None:
    assert support(np.array([0]), np.array([3]), 2).tolist() == [1]
