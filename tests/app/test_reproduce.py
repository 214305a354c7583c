"""The command reproduce: a table to read, files to look at."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinescope.__main__ import main


def test_it_prints_the_table_and_names_the_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--figure", "1", "--out", str(tmp_path / "new")]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("| figure | quantity | paper | ours |")
    assert printed.rstrip().endswith(f"3 files in {tmp_path / 'new'}")


def test_an_unknown_figure_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--figure", "99", "--out", str(tmp_path)]) == 2
    assert "there is no figure 99" in capsys.readouterr().err
