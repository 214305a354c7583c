"""The command `twin`: its table, its figures, and what it refuses."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam.lab.evaluation import Figures
from bspline_slam.lab.twin_trial import CurveErrors, TwinErrors
from splinescope.__main__ import main
from splinescope.command_line import twin_table as table

REPOSITORY = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of a run over the small sample."""
    folder = tmp_path_factory.mktemp("twin") / "results"
    assert main(["run", str(REPOSITORY / "sample_logs" / "three_splines.log.gz"), "--out", str(folder)]) == 0
    return folder


def errors(position: float, graph: float = 0.01) -> TwinErrors:
    """A trial whose errors are all the same."""
    same, other = Figures.of(np.full(3, position)), Figures.of(np.full(3, graph))
    figures = {"position": same, "heading": same, "adjusted": same, "pose_graph": other}
    counts = {"scans": 9, "key_scans": 3, "control_points": 40, "lost": 1}
    ratios = {"chi2_per_dof": 1.0, "processor_seconds": 2.0}
    curves = CurveErrors(np.ones(5), np.array([0, 0, 0, 2, 2]), np.array([True, False, False, False, True]), 0.0)
    squares = {"pose_nees": np.array([3.0, 3.0]), "curves": curves}
    values: dict[str, Any] = figures | counts | ratios | squares
    assert set(values) == {field.name for field in fields(TwinErrors)}
    return TwinErrors(**values)


def test_the_table_has_a_line_for_each_seed_and_one_for_all(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["twin", str(results), "--seeds", "2", "--seed", "7", "--scans", "0:40"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["seed", "7", "8", "all"]
    assert len({len(line) for line in lines[:4]}) == 1
    assert any("pose ANEES" in line and "–" in line for line in lines[4:])


def test_figures_as_json_are_those_of_the_seeds_alone(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for first, count in ((0, 2), (1, 1)):
        words = ["twin", str(results), "--seed", str(first), "--seeds", str(count), "--scans", "10:20", "--json"]
        assert main(words) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert [one["seed"] for one in found[0]["seeds"]] == [0, 1]
    both, alone = found[0]["seeds"][1], found[1]["seeds"][0]
    assert both["position"] == alone["position"] and both["scans"] == 10
    assert found[0]["all"]["position_largest_m"] == max(one["position"]["maximum"] for one in found[0]["seeds"])


def test_all_seeds_together_have_means_and_the_largest_error() -> None:
    together = table.summary([errors(0.001), errors(0.003)])
    assert together["position_mean_m"] == pytest.approx(0.002)
    assert together["position_largest_m"] == pytest.approx(0.003)
    assert together["improvement"] == pytest.approx(1 - 0.002 / 0.01)
    assert together["lost_key_scans"] == 2 and together["pose_anees"]["value"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["nowhere"], "nowhere: is not a folder with the results of a run"),
        (["{results}", "--seeds", "0"], "at least one seed is needed"),
        (["{results}", "--scans", "all"], "--scans is FIRST:LAST, two numbers of scans, got all"),
        (["{results}", "--scans", "9000:9010"], "none from 9000 on"),
        (["{results}", "--log", "{office}"], "is not the log that results was made from"),
    ],
)
def test_a_mistake_is_one_sentence(
    words: list[str], sentence: str, results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = {"results": results, "office": REPOSITORY / "sample_logs" / "office.log.gz"}
    assert main(["twin", *(word.format(**places) for word in words)]) == 2
    assert sentence in capsys.readouterr().err
