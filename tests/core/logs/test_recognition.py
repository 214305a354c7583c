"""Formats are told by content, and whatever is no log ends in one clear sentence."""

from __future__ import annotations

import bz2
import gzip
import hashlib
import lzma
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam.errors import LogError
from bspline_slam.logs import open_log

Write = Callable[..., Path]
NewBag = Callable[[str], Any]


@pytest.mark.parametrize("name", ["drive.log", "drive.clf", "drive.bag", "drive.mcap", "drive"])
@pytest.mark.parametrize("pack", [bytes, gzip.compress, bz2.compress, lzma.compress])
def test_carmen_under_any_name(name: str, pack: Callable[[bytes], bytes], carmen, tmp_path: Path) -> None:
    text = "\n".join(carmen.drive(5)).encode()
    path = tmp_path / name
    path.write_bytes(pack(text))
    log = open_log(path)
    assert len(log) == 5 and log.content_hash == hashlib.sha256(path.read_bytes()).hexdigest()


def test_path_as_text(carmen, write_lines: Write) -> None:
    assert len(open_log(str(write_lines(carmen.drive(2))))) == 2


def test_gzipped_bag(new_bag: NewBag, tmp_path: Path) -> None:
    bag = new_bag("bag")
    bag.drive(3)
    path = tmp_path / "drive.gz"
    path.write_bytes(gzip.compress(bag.write(tmp_path).read_bytes()))
    assert len(open_log(path)) == 3


def test_gzip_of_several_members(carmen, tmp_path: Path) -> None:
    path = tmp_path / "drive.log.gz"
    path.write_bytes(b"".join(gzip.compress(f"{line}\n".encode()) for line in carmen.drive(4)) + b"padding")
    assert len(open_log(path)) == 4


def test_gzip_that_was_cut_off(carmen, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    lines = [carmen.flaser(i, (i, 0, 0), readings=rng.uniform(1, 9, 180).round(3)) for i in range(300)]
    packed = gzip.compress("\n".join(lines).encode())
    path = tmp_path / "drive.log.gz"
    path.write_bytes(packed[: len(packed) // 2])
    log = open_log(path)
    assert 100 < len(log) < 200
    assert any("gzip file is cut off" in note for note in log.notes)


def test_gzip_that_is_damaged(carmen, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    lines = [carmen.flaser(i, (i, 0, 0), readings=rng.uniform(1, 9, 180).round(3)) for i in range(600)]
    packed = bytearray(gzip.compress("\n".join(lines).encode()))
    packed[-60_000:-59_000] = bytes(1000)
    path = tmp_path / "drive.log.gz"
    path.write_bytes(packed)
    log = open_log(path)
    assert 0 < len(log) < 600 and any("gzip file is damaged" in note for note in log.notes)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "the file is empty"),
        (gzip.compress(b""), "empty once unpacked"),
        (b"\x1f\x8b\x08", "the gzip file is cut off"),
        (b"\x1f\x8bnot gzip at all", "the gzip file is damaged"),
        (bytes(range(256)) * 20, "the content is binary"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "the content is binary"),
        (bz2.compress(b""), "empty once unpacked"),
        (lzma.compress(b"FLASER")[:20], "the xz file is cut off: nothing can be unpacked"),
        (b"PK\x03\x04\x14\x00", r"packed file \(zip\): unpack it first"),
        (gzip.compress(b"\x89MCAP0\r\n"), "a packed ROS 2 bag: unpack it first"),
        (b"Dear diary,\ntoday the robot stood still.\n", "not a laser log: no line begins with FLASER"),
        (b"\n\n\n", "not a laser log"),
    ],
)
def test_what_is_no_log(content: bytes, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "some.log"
    path.write_bytes(content)
    with pytest.raises(LogError, match=sentence) as caught:
        open_log(path)
    assert str(caught.value).startswith("some.log: ") and "\n" not in str(caught.value)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"^nowhere.log: no such file or folder$"):
        open_log(tmp_path / "nowhere.log")


def test_file_that_cannot_be_opened(tmp_path: Path) -> None:
    loop = tmp_path / "loop.log"
    loop.symlink_to(loop)
    with pytest.raises(LogError, match=r"^loop.log: "):
        open_log(loop)


def test_special_file() -> None:
    with pytest.raises(LogError, match="neither a file nor a folder"):
        open_log("/dev/null")


def test_zeros_at_the_end_of_a_crashed_recording(carmen, tmp_path: Path) -> None:
    path = tmp_path / "drive.log"
    path.write_bytes("\n".join([*carmen.drive(60), ""]).encode() + bytes(5000))
    log = open_log(path)
    assert len(log) == 60 and any("unknown kind" in note for note in log.notes)


def test_index_outside_the_log(carmen, write_lines: Write) -> None:
    log = open_log(write_lines(carmen.drive(3)))
    assert log[-3].index == 0
    for index in (3, -4):
        with pytest.raises(IndexError, match="3 scans"):
            log[index]
