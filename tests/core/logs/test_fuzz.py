"""Whatever the bytes: a log that can be read in full, or a LogError."""

from __future__ import annotations

import gzip
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bspline_slam.errors import LogError
from bspline_slam.logs import open_log
from core.logs.conftest import Bag, Carmen

SHARED_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
EDITS = st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 40), st.binary(max_size=12)), min_size=1, max_size=8)


def open_and_read(path: Path) -> None:
    """Open a log and look at all of it; a LogError of one line is a good end."""
    try:
        log = open_log(path)
    except LogError as error:
        assert str(error).startswith(path.name) and "\n" not in str(error)
        return
    assert len(log) > 0 and np.all(np.diff(log.records.times) > 0)
    assert all(isinstance(note, str) for note in log.notes)
    for index, scan in enumerate(log):
        assert scan.index == index and len(scan.ranges) == len(scan.bearings) > 0
        assert np.all(np.diff(scan.bearings) > 0) and scan.range_max > scan.range_min
        assert np.isfinite(scan.points_robot[scan.valid]).all() and np.isfinite(scan.pose_robot_sensor).all()
    if log.records.odometry is not None:
        assert np.isfinite(log.records.odometry).all()


def mutated(data: bytes, edits: list[tuple[int, int, bytes]]) -> bytes:
    """The bytes with some stretches replaced."""
    for place, length, replacement in edits:
        start = place % len(data)
        data = data[:start] + replacement + data[start + length :]
        if not data:
            return b""
    return data


@cache
def recording(kind: str) -> bytes:
    """A short recording in one format."""
    bag = Bag(kind)
    bag.drive(3)
    bag.transform(100.1, "odom", "base_link", (1, 0, 0))
    with TemporaryDirectory() as folder:
        return bag.write_file(Path(folder)).read_bytes()


@SHARED_FOLDER
@given(st.binary(max_size=400))
def test_random_bytes(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "noise.log"
    path.write_bytes(data)
    open_and_read(path)


@SHARED_FOLDER
@given(
    st.sampled_from([b"\x1f\x8b", b"\x1f\x8b\x08\x00", b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n", b"SQLite format 3\x00"]),
    st.binary(max_size=300),
)
def test_random_bytes_behind_a_magic_number(tmp_path: Path, magic: bytes, data: bytes) -> None:
    path = tmp_path / "noise.log"
    path.write_bytes(magic + data)
    open_and_read(path)


WORDS = st.sampled_from(
    ["FLASER", "RLASER", "ROBOTLASER1", "ODOM", "TRUEPOS", "PARAM", "robot_front_laser_max", "robot", "#"]
)
VALUES = st.one_of(
    st.integers(-3, 400).map(str),
    st.floats().map(str),
    st.sampled_from(["nan", "-inf", "1e400", "0x1", "1_0", "é", "\x00"]),
)


@SHARED_FOLDER
@given(st.lists(st.lists(st.one_of(WORDS, VALUES), max_size=24).map(" ".join), max_size=12))
def test_random_words(tmp_path: Path, lines: list[str]) -> None:
    path = tmp_path / "words.log"
    path.write_text("\n".join(lines), errors="replace")
    open_and_read(path)


@SHARED_FOLDER
@given(
    st.lists(st.lists(st.floats(allow_nan=True), min_size=1, max_size=6), min_size=1, max_size=6),
    st.lists(st.tuples(st.floats(-1e13, 1e13), st.floats(-1e13, 1e13)), min_size=6, max_size=6),
    st.floats(-7, 7),
)
def test_any_numbers(tmp_path: Path, scans: list[list[float]], poses: list[tuple[float, float]], step: float) -> None:
    path = tmp_path / "numbers.log"
    lines = [Carmen.flaser(t, (x, t, x), readings=r) for r, (t, x) in zip(scans, poses, strict=False)]
    lines += [Carmen.robotlaser(poses[0][0], scans[0], poses[1][0], step, poses[1][1])]
    path.write_text("\n".join(lines))
    open_and_read(path)
    path.write_text(lines[-1])
    open_and_read(path)


@SHARED_FOLDER
@given(EDITS, st.booleans())
def test_mutated_carmen_logs(tmp_path: Path, edits: list[tuple[int, int, bytes]], packed: bool) -> None:
    carmen = Carmen()
    text = "\n".join(["PARAM robot_front_laser_max 30", *carmen.drive(4), carmen.odom(11, (1, 0, 0))]).encode()
    path = tmp_path / "drive.log"
    path.write_bytes(mutated(gzip.compress(text), edits) if packed else mutated(text, edits))
    open_and_read(path)


@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
@SHARED_FOLDER
@given(edits=EDITS, cut=st.integers(0, 10**9))
def test_mutated_bags(tmp_path: Path, kind: str, edits: list[tuple[int, int, bytes]], cut: int) -> None:
    data = recording(kind)
    path = tmp_path / f"drive.{kind}"
    for damaged in (
        mutated(data, edits),
        mutated(data, [(p, len(r), r) for p, _, r in edits]),
        data[: cut % len(data)],
    ):
        path.write_bytes(damaged)
        open_and_read(path)
