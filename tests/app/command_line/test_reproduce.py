"""The command reproduce: a table to read, files to look at."""

from __future__ import annotations

from pathlib import Path

import pytest

from bspline_slam.lab import reproduction
from splinescope.__main__ import main


def test_it_prints_the_table_and_names_the_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--figure", "1", "--out", str(tmp_path / "new")]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("| figure | quantity | paper | ours |")
    assert printed.rstrip().endswith(f"3 files in {tmp_path / 'new'}")


def test_what_needs_the_intel_log_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--figure", "9", "--out", str(tmp_path)]) == 2
    assert "--intel PATH" in capsys.readouterr().err
    assert main(["reproduce", "--figure", "1", "--intel", str(tmp_path / "none.log"), "--out", str(tmp_path)]) == 2
    assert "there is no log" in capsys.readouterr().err


def test_all_figures_without_the_log_name_the_one_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reproduction, "EXPERIMENTS", reproduction.EXPERIMENTS[:1])
    assert main(["reproduce", "--out", str(tmp_path)]) == 0
    assert "Figure 9 was left out" in capsys.readouterr().out


def test_an_unknown_figure_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--figure", "99", "--out", str(tmp_path)]) == 2
    assert "there is no figure 99" in capsys.readouterr().err
