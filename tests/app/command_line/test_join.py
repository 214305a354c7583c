"""The command that joins local maps: what it prints, what it writes, what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from core.point_maps import arrays, survey
from splinescope.__main__ import main


@pytest.fixture
def maps(tmp_path: Path) -> Path:
    np.savez(tmp_path / "maps.npz", **arrays(survey(np.random.default_rng(0), maps=9, laps=1).maps))  # pyright: ignore[reportArgumentType]
    return tmp_path / "maps.npz"


def test_json_is_one_object_and_the_joint_map_is_written(maps: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["join", str(maps), "--out", str(maps.parent / "new" / "out"), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    with np.load(maps.parent / "new" / "out" / "joint.npz") as joint:
        assert joint["poses"].shape == (figures["maps"] + 1, 3) == (10, 3)
        assert joint["features"].shape == (figures["features"], 2)
        assert joint["feature_ids"].shape == (figures["features"],)
        row, column, value = joint["information"].T
        assert max(row.max(), column.max()) == figures["states"] - 1 == 3 * 9 + 2 * figures["features"] - 1
        assert np.all(value[row == column] > 0)
    assert figures["converged"] is True
    assert 0.3 < figures["chi2"] / figures["dof"] < 3.0
    assert figures["iterations"] >= 1
    assert figures["seconds"] > 0


def test_the_text_names_the_figures(maps: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["join", str(maps), "--out", str(maps.parent)]) == 0
    printed = capsys.readouterr().out
    for words in ("9 maps", "features", "iterations", "χ²", "degrees of freedom", " s\n", "joint.npz"):
        assert words in printed


def test_mistakes_are_one_sentence_and_leave_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.savez(tmp_path / "maps.npz", x0=np.zeros(3), P0=-np.eye(3), id0=np.zeros(0, dtype=int))
    (tmp_path / "text.npz").write_text("no archive")
    for name, sentence in (
        ("maps.npz", "maps.npz: P0 is not positive definite"),
        ("text.npz", "text.npz: is no .npz file of plain arrays"),
        ("nowhere.npz", "nowhere.npz: No such file or directory"),
    ):
        assert main(["join", str(tmp_path / name), "--out", str(tmp_path / "out")]) == 2
        error = capsys.readouterr().err
        assert sentence in error
        assert "Traceback" not in error
    assert not (tmp_path / "out").exists()
