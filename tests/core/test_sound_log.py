"""Logs that cannot be mapped are refused in one sentence, before any work is done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bspline_slam.errors import LogError
from bspline_slam.logs.indexed_log import IndexedLog
from bspline_slam.scan import LaserScan, Records
from bspline_slam.slam import run_slam
from bspline_slam.sound_log import check_log
from core.rooms import loop_path, room_scan

PATH = loop_path(60)[:12]
SCANS = tuple(room_scan(pose, np.random.default_rng(k), index=k) for k, pose in enumerate(PATH))


def log_of(scans: Sequence[LaserScan], times: np.ndarray, odometry: np.ndarray | None) -> IndexedLog:
    records = Records(times, times, odometry, np.arange(len(scans)))
    return IndexedLog.from_records(Path("odd.log"), records, None, (), "", scans.__getitem__)


def with_a_nan(values: np.ndarray) -> np.ndarray:
    return np.where(np.arange(values.size).reshape(values.shape) == values.size - 1, np.nan, values)


def in_millimetres(scan: LaserScan) -> LaserScan:
    return replace(scan, ranges=1e3 * scan.ranges, range_max=1e3 * scan.range_max)


TIMES = np.arange(12.0)
REFUSED = {
    "no laser scan": log_of((), np.zeros(0), np.zeros((0, 3))),
    "the odometry of scan 11": log_of(SCANS, TIMES, with_a_nan(PATH)),
    "the time of scan 11": log_of(SCANS, with_a_nan(TIMES), PATH),
    "millimetres": log_of(tuple(map(in_millimetres, SCANS)), TIMES, PATH),
}


@pytest.mark.parametrize("sentence", REFUSED)
def test_what_cannot_be_mapped_is_refused_and_says_why(sentence: str) -> None:
    with pytest.raises(LogError, match=rf"odd\.log: .*{sentence}"):
        run_slam(REFUSED[sentence])


def test_scans_that_see_nothing_or_only_now_and_then_too_far_are_no_reason_to_refuse() -> None:
    blank = tuple(replace(scan, ranges=np.full_like(scan.ranges, np.nan)) for scan in SCANS)
    far = tuple(replace(s, ranges=np.where(np.arange(len(s.ranges)) == 7, 1e7, s.ranges)) for s in SCANS)
    for scans in (SCANS, blank, far):
        check_log(log_of(scans, TIMES, PATH))
        check_log(log_of(scans, TIMES, None))
