"""ICP by kiss-icp, which shares its sums among as many cores as there are."""

import os
import subprocess
import sys

import pytest

ALIGNED = """
import os, sys
if sys.argv[1] == "one":
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
import numpy as np
from bspline_slam.front_end.icp import IcpConfig, align, icp_map
rng = np.random.default_rng(0)
for count in (400, 3000):
    points = rng.uniform(-5.0, 5.0, (count, 2))
    seen = points[: count // 2] + rng.normal(0.0, 0.02, (count // 2, 2))
    print(align(icp_map(points, IcpConfig()), seen, np.array([0.05, 0.02, 0.03]), IcpConfig()).tolist())
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be chosen on this system")
def test_no_digit_hangs_on_the_number_of_cores() -> None:
    def told(cores: str) -> str:
        return subprocess.run([sys.executable, "-c", ALIGNED, cores], capture_output=True, text=True, check=True).stdout

    assert told("one") == told("all")
