"""ROS 1 bags are read from their chunks: the index may be wrong or missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rosbags.rosbag1 import Writer

from bspline_slam.errors import LogError
from bspline_slam.logs import open_log

NewBag = Callable[[str], Any]


@pytest.fixture
def written(new_bag: NewBag, tmp_path: Path) -> Path:
    bag = new_bag("bag")
    bag.drive(10)
    return bag.write(tmp_path)


@pytest.mark.parametrize("compression", ["BZ2", "LZ4"])
def test_compressed_chunks(compression: str, new_bag: NewBag, tmp_path: Path) -> None:
    bag = new_bag("bag")
    bag.drive(10)
    prepare = lambda writer: writer.set_compression(Writer.CompressionFormat[compression])  # noqa: E731
    assert len(open_log(bag.write(tmp_path, prepare=prepare))) == 10


def test_index_records_that_announce_too_many_bytes(written: Path) -> None:
    data = bytearray(written.read_bytes())
    count = data.index(b"count=" + (10).to_bytes(4, "little"))  # the index of the ten scans, of twelve bytes each
    length = data.index((120).to_bytes(4, "little"), count)
    data[length : length + 4] = (200).to_bytes(4, "little")
    written.write_bytes(data)
    log = open_log(written)
    assert len(log) == 10 and log.notes == ()


def test_bag_that_was_cut_off(written: Path) -> None:
    data = written.read_bytes()
    written.write_bytes(data[: data.index(b"op=\x04")])  # in the index of the first chunk
    log = open_log(written)
    assert len(log) == 10 and any("cut off" in note and "byte" in note for note in log.notes)


@pytest.mark.parametrize("share", [0.5, 0.75, 0.9])
def test_bag_cut_off_within_its_only_chunk(share: float, new_bag: NewBag, tmp_path: Path) -> None:
    bag = new_bag("bag")
    for i in range(100):
        bag.scan(1.0 + i, ranges=[1.0] * 360)
    path = bag.write(tmp_path)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    log = open_log(path)
    assert abs(len(log) - 100 * share) < 6 and any("cut off" in note for note in log.notes)


def test_bag_cut_off_before_its_first_message(written: Path) -> None:
    written.write_bytes(written.read_bytes()[:4150])
    with pytest.raises(LogError, match=r"no other topic either. The bag is cut off"):
        open_log(written)


def test_damaged_chunk_is_left_out(new_bag: NewBag, tmp_path: Path) -> None:
    bag = new_bag("bag")
    for i in range(2000):
        bag.scan(1.0 + i, ranges=[1.0] * 360)
    path = bag.write(tmp_path, prepare=lambda writer: writer.set_compression(Writer.CompressionFormat.BZ2))
    data = bytearray(path.read_bytes())
    second = data.index(b"BZh9", data.index(b"BZh9") + 4)
    data[second + 10 : second + 60] = bytes(50)
    path.write_bytes(data)
    log = open_log(path)
    assert 0 < len(log) < 2000 and any("1 damaged chunks" in note for note in log.notes)


def test_old_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "old.bag"
    path.write_bytes(b"#ROSBAG V1.2\n" + bytes(100))
    with pytest.raises(LogError, match=r"old.bag: the bag has format 1.2, only 2.0"):
        open_log(path)
