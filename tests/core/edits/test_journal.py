"""The journal: nothing accepted is ever lost, whatever kills the program; damage is noticed and named."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bspline_slam.edits.edit import DropLoop
from bspline_slam.edits.history import Accept, GoTo, History, Operation
from bspline_slam.edits.journal import Journal, Origin, read_journal
from bspline_slam.errors import EditError
from core.edits.drawn import OPERATIONS

ORIGIN = Origin("/logs/a.log", "abc", {"back_end": "direct", "gates": [0.1, 0.2]})


def numbered(number: int) -> Accept:
    return Accept(f"number {number}", 0.0, (DropLoop(number, number + 1),))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "folder" / "a.edits"


@pytest.fixture
def journal(path: Path) -> Iterator[Journal]:
    journal = Journal(path, ORIGIN)
    yield journal
    journal.close()


@settings(max_examples=25)
@given(st.lists(OPERATIONS, max_size=12))
def test_a_journal_gives_back_the_history(
    tmp_path_factory: pytest.TempPathFactory, operations: list[Operation]
) -> None:
    path = tmp_path_factory.mktemp("journal") / "a.edits"
    journal, expected = Journal(path, ORIGIN), History()
    for operation in operations:
        try:
            expected = expected.after(operation)
        except EditError:
            with pytest.raises(EditError):
                journal.append(operation)
        else:
            assert journal.append(operation) == expected
    journal.close()
    assert read_journal(path).history == expected
    again = Journal(path, ORIGIN)
    assert again.history == expected
    again.close()


def test_it_says_what_it_belongs_to(journal: Journal, path: Path) -> None:
    origin = read_journal(path).origin
    assert (origin.log, origin.content_hash, origin.configuration) == ("/logs/a.log", "abc", ORIGIN.configuration)


@settings(max_examples=40)
@given(st.data())
def test_a_torn_end_loses_only_what_was_never_accepted(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("journal") / "a.edits"
    journal, sizes = Journal(path, ORIGIN), [0]
    sizes.append(path.stat().st_size)
    for number in range(4):
        journal.append(numbered(number))
        sizes.append(path.stat().st_size)
    journal.close()
    cut = data.draw(st.integers(0, sizes[-1]))
    os.truncate(path, cut)
    whole = sum(size <= cut for size in sizes) - 2
    again = Journal(path, ORIGIN)
    assert len(again.history.entries) == max(whole, 0)
    assert bool(again.notes) == (cut not in sizes and whole >= 0)
    again.append(numbered(9))
    again.close()
    entries = read_journal(path).history.entries
    assert len(entries) == max(whole, 0) + 1


@pytest.mark.parametrize("line", [0, 1, 2])
def test_damage_in_the_middle_is_one_sentence(journal: Journal, path: Path, line: int) -> None:
    for number in range(3):
        journal.append(numbered(number))
    journal.close()
    lines = path.read_bytes().split(b"\n")
    lines[line] = lines[line].replace(b"1", b"7", 1) if line else b"nothing"
    path.write_bytes(b"\n".join(lines))
    with pytest.raises(EditError, match="damaged") as error:
        read_journal(path)
    assert "\n" not in str(error.value)


def test_a_line_taken_out_is_noticed(journal: Journal, path: Path) -> None:
    for number in range(3):
        journal.append(numbered(number))
    lines = path.read_bytes().split(b"\n")
    path.write_bytes(b"\n".join([*lines[:2], *lines[3:]]))
    with pytest.raises(EditError, match=r"a\.edits:3"):
        read_journal(path)


@pytest.mark.parametrize("content", [b"hello\n", b"hello", b"{}\n", b"\xff\xfe\n"])
def test_another_file_is_not_touched(path: Path, content: bytes) -> None:
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(EditError, match="no journal"):
        Journal(path, ORIGIN)
    assert path.read_bytes() == content


def test_another_log_and_another_configuration_are_refused(journal: Journal, path: Path) -> None:
    journal.close()
    with pytest.raises(EditError, match=r"another log: /logs/a\.log"):
        Journal(path, Origin("/logs/b.log", "def", ORIGIN.configuration))
    with pytest.raises(EditError, match="another configuration"):
        Journal(path, Origin("/logs/a.log", "abc", {}))


def test_the_same_log_elsewhere_is_accepted(journal: Journal, path: Path) -> None:
    journal.append(numbered(0))
    journal.close()
    moved = Journal(path, Origin("/elsewhere/a.log", "abc", ORIGIN.configuration))
    assert len(moved.history.entries) == 1
    moved.close()


def test_two_programs_do_not_write_at_once(journal: Journal, path: Path) -> None:
    with pytest.raises(EditError, match="open in another"):
        Journal(path, ORIGIN)


def test_what_makes_no_sense_is_not_written(journal: Journal, path: Path) -> None:
    before = path.read_bytes()
    with pytest.raises(EditError):
        journal.append(GoTo(3))
    assert path.read_bytes() == before


def test_a_full_disk_is_a_sentence_and_nothing_is_half_written(
    journal: Journal, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal.append(numbered(1))
    before = path.read_bytes()
    with monkeypatch.context() as full:
        full.setattr(os, "fsync", _full)
        with pytest.raises(EditError, match=r"a\.edits cannot be written: No space left on device$"):
            journal.append(numbered(2))
    assert path.read_bytes() == before
    journal.append(numbered(3))
    assert read_journal(path).history == journal.history == History().after(numbered(1)).after(numbered(3))


def _full(descriptor: int) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_journal_that_was_removed_is_not_written_into_nothing(journal: Journal, path: Path) -> None:
    journal.append(numbered(1))
    path.unlink()
    with pytest.raises(EditError, match="has been removed"):
        journal.append(numbered(2))
    assert journal.history == History().after(numbered(1))


def test_kill_minus_nine_loses_nothing_that_was_accepted(path: Path) -> None:
    """A hundred times: a process accepts edits and is killed at a random moment; the next goes on after it."""
    script = Path(__file__).with_name("killed_journal.py")
    done = subprocess.run([sys.executable, str(script), str(path), "100"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rounds, entries = map(int, done.stdout.split())
    assert rounds == 100
    assert len(read_journal(path).history.entries) == entries >= 100
