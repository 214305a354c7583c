"""ROS 2 folders that are whole, compressed, damaged, or no bag at all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode

from bspline_slam.errors import LogError
from bspline_slam.logs import open_log

NewBag = Callable[[str], Any]


@pytest.fixture(params=["db3", "mcap"])
def folder(request: pytest.FixtureRequest, new_bag: NewBag, tmp_path: Path) -> Path:
    bag = new_bag(request.param)
    bag.drive(10)
    return bag.write(tmp_path)


def storage(folder: Path) -> Path:
    """The file that holds the messages."""
    return next(file for file in folder.iterdir() if file.suffix != ".yaml")


@pytest.mark.parametrize("kind", ["db3", "mcap"])
@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compressed_folders(kind: str, mode: CompressionMode, new_bag: NewBag, tmp_path: Path) -> None:
    if kind == "mcap" and mode is CompressionMode.FILE:
        mode = CompressionMode.STORAGE  # MCAP compresses its own chunks
    bag = new_bag(kind)
    bag.drive(10)
    path = bag.write(tmp_path, prepare=lambda writer: writer.set_compression(mode, CompressionFormat.ZSTD))
    log = open_log(path)
    assert len(log) == 10 and len(log.content_hash) == 64


def test_folder_without_metadata(folder: Path) -> None:
    (folder / "metadata.yaml").unlink()
    assert len(open_log(folder)) == 10


@pytest.mark.parametrize("text", ["", "]: {", "rosbag2_bagfile_information: {version: 99}", "a: 1"])
def test_damaged_metadata_is_done_without(text: str, folder: Path) -> None:
    (folder / "metadata.yaml").write_text(text)
    log = open_log(folder)
    assert len(log) == 10 and any("without its metadata.yaml" in note for note in log.notes)


def test_metadata_whose_files_are_gone(folder: Path) -> None:
    storage(folder).unlink()
    with pytest.raises(LogError, match=r"cannot be opened, .*missing"):
        open_log(folder)


def test_folder_that_is_no_bag(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("nothing here")
    with pytest.raises(LogError, match=r"is no ROS 2 bag: it holds neither metadata.yaml nor"):
        open_log(tmp_path)


def test_several_files_follow_each_other(new_bag: NewBag, tmp_path: Path) -> None:
    together = tmp_path / "together"
    together.mkdir()
    for number in (0, 1):
        bag = new_bag("mcap")
        for i in range(3):
            bag.scan(10.0 * number + i)
        bag.write_file(tmp_path, f"part{number}").rename(together / f"part_{number}.mcap")
    (together / "part_2.mcap").write_bytes(b"\x89MCAP0\r\n and nothing more")
    log = open_log(together)
    assert log.records.stamps.tolist() == [0, 1, 2, 10, 11, 12]
    assert any("part_2.mcap is left out" in note for note in log.notes)


@pytest.mark.parametrize("keep", [20, 200, 2000])
def test_file_that_was_cut_off(keep: int, folder: Path) -> None:
    file = storage(folder)
    file.write_bytes(file.read_bytes()[:keep])
    with pytest.raises(LogError, match=r"cannot be opened|holds no sensor_msgs/LaserScan"):
        open_log(file)


def test_the_hash_is_that_of_the_messages(folder: Path) -> None:
    assert open_log(folder).content_hash == open_log(storage(folder)).content_hash
