"""One thread of dense linear algebra, whatever the machine would give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info, threadpool_limits

from bspline_slam.backends.threads import in_one_thread, single_thread
from bspline_slam.logs import open_log
from bspline_slam.slam import run_slam

SAMPLE = Path(__file__).parents[3] / "sample_logs" / "three_splines.log.gz"


def threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_a_function_runs_in_one_thread_and_leaves_things_as_they_were() -> None:
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        assert in_one_thread(threads)() == {1}
        assert threads() == before
        with single_thread(), single_thread():
            assert threads() == {1}


def test_a_map_is_the_same_with_any_number_of_threads() -> None:
    log, found = open_log(SAMPLE), []
    for number in (1, 2):
        with threadpool_limits(number, user_api="blas"):
            found.append(run_slam(log).snapshot)
    one, two = found
    np.testing.assert_array_equal(one.poses, two.poses)
    for mine, other in zip(one.map, two.map, strict=True):
        np.testing.assert_array_equal(mine.curve.control_points, other.curve.control_points)
