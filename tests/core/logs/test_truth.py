"""True poses from a file beside the log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam.logs import open_log
from bspline_slam.logs.truth import companion

Write = Callable[..., Path]


def tum(stamps: np.ndarray, heading: float = 0.5) -> str:
    """Poses (t, 2t, heading) as lines `t x y z qx qy qz qw`."""
    sine, cosine = np.sin(heading / 2), np.cos(heading / 2)
    return "# t x y z qx qy qz qw\n" + "".join(f"{t:.6f} {t} {2 * t} 0 0 0 {sine} {cosine}\n" for t in stamps)


@pytest.mark.parametrize("name", ["office.log.gz", "office.log", "office.clf", "office.mcap", "office.bag", "office"])
def test_the_companion_of_a_log(name: str, tmp_path: Path) -> None:
    assert companion(tmp_path / name) is None
    truth = tmp_path / "office.truth.tum"
    truth.write_text(tum(np.arange(3.0)))
    assert companion(tmp_path / name) == truth


def test_truth_at_the_stamps_of_the_scans(carmen, write_lines: Write) -> None:
    path = write_lines(carmen.drive(10))
    path.with_name("drive.truth.tum").write_text(tum(np.arange(10.0, 12.0, 0.05)))
    log = open_log(path)
    stamps = log.records.stamps
    assert log.truth is not None
    assert np.allclose(log.truth, np.column_stack([stamps, 2 * stamps, np.full(10, 0.5)]))


def test_truth_beside_a_bag(bag: Any, tmp_path: Path) -> None:
    bag.drive(10)
    path = bag.write(tmp_path)
    (tmp_path / "drive.truth.tum").write_text(tum(np.arange(100.0, 101.0, 0.1)))
    log = open_log(path)
    assert log.truth is not None and np.allclose(log.truth[:, 0], log.records.stamps)


def test_own_truth_comes_first(carmen, write_lines: Write) -> None:
    path = write_lines([carmen.truepos(10.0, (7, 7, 0)), *carmen.drive(3)])
    path.with_name("drive.truth.tum").write_text(tum(np.arange(10.0, 12.0)))
    log = open_log(path)
    assert log.truth is not None and np.allclose(log.truth[:, 0], 7)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", "eight numbers"),
        ("1 2 3\n", "eight numbers"),
        ("1 2 3 4\n" * 4, "eight numbers"),
        ("a b c d e f g h\n", "eight numbers"),
        ("10 0 0 0 0 0 0 nan\n", "eight numbers"),
        (tum(np.arange(5000.0, 5010.0)), "times are not those of the scans"),
    ],
)
def test_truth_that_does_not_serve_is_said(content: str, sentence: str, carmen, write_lines: Write) -> None:
    path = write_lines(carmen.drive(10))
    path.with_name("drive.truth.tum").write_text(content)
    log = open_log(path)
    assert log.truth is None and any(sentence in note and "drive.truth.tum" in note for note in log.notes)


def test_truth_that_ends_early_is_held(carmen, write_lines: Write) -> None:
    path = write_lines(carmen.drive(10))
    path.with_name("drive.truth.tum").write_text(tum(np.arange(10.0, 10.65, 0.1)))
    log = open_log(path)
    assert log.truth is not None and np.allclose(log.truth[-1, 0], 10.6)
    assert any("does not reach 20% of the scans" in note for note in log.notes)
