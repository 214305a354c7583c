"""The command that holds errors against covariances: experiments by name, runs in processes, tables and files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from bspline_slam.errors import ConfigError
from bspline_slam.lab.consistency import Experiment, run_once
from bspline_slam.lab.consistency_table import summarise
from splinescope.__main__ import main
from splinescope.command_line.consistency import experiments, figures, run_experiments, table, write_results

KEYS = (
    "world", "model", "backend", "association", "runs", "pose_anees", "pose_band", "curve_anees", "curve_band",
    "coverage_2sigma", "coverage_band",
)  # fmt: skip


def test_five_runs_give_a_row_with_every_figure_and_the_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["consistency", "--runs", "5", "--world", "three_splines", "--association", "truth"]
    assert main([*command, "--out", str(tmp_path), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "consistency.json").read_text())
    (row,) = printed["rows"]
    assert row.keys() >= set(KEYS)
    assert (row["world"], row["backend"], row["association"], row["runs"]) == ("three_splines", "direct", "truth", 5)
    assert row["pose_band"][0] < row["pose_anees"] < 1.5 * row["pose_band"][1]
    assert row["curve_band"][0] < 1.0 < row["curve_band"][1]
    assert 0.5 < row["coverage_2sigma"] <= 1.0
    drawing = ElementTree.parse(tmp_path / "consistency.svg").getroot()
    assert any("three_splines" in (text.text or "") for text in drawing.iter("{http://www.w3.org/2000/svg}text"))
    written = (tmp_path / "consistency.md").read_text()
    assert (
        written.startswith("`splinescope consistency --runs 5 --world three_splines ") and "| three_splines" in written
    )


def test_a_run_in_a_process_of_its_own_is_the_same_run() -> None:
    (wanted,) = experiments(["corridor"], ["normal-distance"], ["direct"], ["truth"])
    (row,) = run_experiments([wanted], 1, 7, lambda stage, share: None, lambda: False)
    here = run_once(wanted, np.random.default_rng([7, 0]))
    assert row.curve.value == pytest.approx(here.curve_nees / here.curve_dof, rel=1e-6)
    assert row.position_error == pytest.approx(here.position_error, rel=1e-6)


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        ((["atlantis"], ["normal-distance"], ["direct"], ["truth"]), "no world or world file called atlantis"),
        ((["corridor"], ["guess"], ["direct"], ["truth"]), 'no model "guess"'),
        ((["corridor"], ["normal-distance"], ["abacus"], ["truth"]), 'no back end "abacus"'),
        ((["corridor"], ["normal-distance"], ["direct"], ["oracle"]), 'no association "oracle"'),
    ],
)
def test_unknown_names_are_refused_before_anything_runs(names: tuple[list[str], ...], sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        experiments(*names)


def test_no_runs_are_no_study() -> None:
    with pytest.raises(ConfigError, match="at least one run"):
        run_experiments([Experiment("corridor")], 0, 0, lambda stage, share: None, lambda: False)


def is_gone(group: int) -> bool:
    """Whether no process of the group is left; waits a moment if there is."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    time.sleep(0.1)
    return False


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is another thing there")
def test_an_interrupt_ends_the_command_with_a_sentence_and_no_process_is_left() -> None:
    command = [sys.executable, "-m", "splinescope", "consistency", "--runs", "500", "--world", "corridor"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stderr is not None and process.stderr.readline().startswith("Simulating and estimating")
    os.killpg(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in error
    assert any(is_gone(process.pid) for _ in range(50))


def test_what_could_not_be_computed_is_null_and_a_dash(tmp_path: Path) -> None:
    row = summarise(Experiment("corridor"), [], ["the solver gave up"])
    assert figures([row])["rows"][0]["pose_anees"] is None
    assert json.loads(json.dumps(figures([row]), allow_nan=False))["rows"][0]["pose_band"] == [None, None]
    assert "| – " in table([row]) and "1 runs failed (the solver gave up)" in table([row])
    write_results([row], tmp_path, "splinescope consistency")
    assert "nan" not in (tmp_path / "consistency.svg").read_text()
    assert np.isnan(row.pose.value)
