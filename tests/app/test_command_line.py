"""Each command from outside, without a display."""

from __future__ import annotations

import gzip
import json
import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.logs import open_log
from splinescope.__main__ import main

SAMPLES = Path(__file__).parents[2] / "sample_logs"
COMMAND = [sys.executable, "-m", "splinescope"]


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("simulated") / "three.log"
    assert main(["simulate", "three_splines", "--out", str(log), "--seed", "3"]) == 0
    return log


@pytest.fixture(scope="module")
def results(simulated: Path) -> Path:
    folder = simulated.parent / "results"
    assert main(["run", str(simulated), "--out", str(folder)]) == 0
    return folder


def complaint(capsys: pytest.CaptureFixture[str], *words: str | Path, code: int = 2) -> str:
    """The one sentence that a refused command leaves on standard error."""
    assert main([str(word) for word in words]) == code
    error = capsys.readouterr().err
    assert "Traceback" not in error
    sentences = [line for line in error.splitlines() if line.startswith("splinescope: ")]
    assert len(sentences) == 1
    return sentences[0]


# -- help --------------------------------------------------------------------------------------------------------


def test_help_names_every_command_and_loads_nothing_heavy() -> None:
    code = "import sys, splinescope.__main__ as m\ntry: m.main(['--help'])\nexcept SystemExit: print(*sys.modules)"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert all(f"\n    {command} " in printed for command in ("view", "run", "evaluate", "simulate", "twin"))
    assert not {"numpy", "gtsam", "viser", "numba"} & set(printed.split())


def test_the_version_is_the_installed_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert re.fullmatch(r"splinescope \d+\.\d+\.\d+\n", capsys.readouterr().out)


# -- simulate, run, evaluate -------------------------------------------------------------------------------------


def test_simulate_writes_a_log_and_its_truth_and_the_seed_decides_them(simulated: Path, tmp_path: Path) -> None:
    main(["simulate", "three_splines", "--out", str(tmp_path / "again.log"), "--seed", "3"])
    main(["simulate", "three_splines", "--out", str(tmp_path / "other.log"), "--seed", "4"])
    assert (tmp_path / "again.log").read_bytes() == simulated.read_bytes()
    assert (tmp_path / "other.log").read_bytes() != simulated.read_bytes()
    assert simulated.with_name("three.truth.tum").is_file()


def test_the_twin_of_a_run_is_a_log_with_its_truth(results: Path, simulated: Path, tmp_path: Path) -> None:
    for name, extra in (("plain", []), ("exact", ["--log", str(simulated)])):
        out = tmp_path / name / "twin.log"
        assert main(["simulate", "--from-map", str(results), "--out", str(out), "--seed", "5", *extra]) == 0
        twin, original = open_log(out), open_log(simulated)
        assert len(twin) == len(original) and len(twin.records.stamps) == len(original.records.stamps)
        assert np.allclose(twin[0].bearings, original[0].bearings, atol=1e-6)
        assert twin.truth is not None and original.truth is not None and twin.odometry is not None
        moved = np.linalg.norm(se2.between(twin.truth[0], twin.truth[-1])[:2])
        assert moved == pytest.approx(np.linalg.norm(se2.between(original.truth[0], original.truth[-1])[:2]), abs=0.05)


def test_run_writes_everything_and_the_report_is_a_configuration(
    results: Path, simulated: Path, tmp_path: Path
) -> None:
    assert {path.name for path in results.iterdir()} == {"trajectory.tum", "map.json", "map.svg", "report.json"}
    report = json.loads((results / "report.json").read_text())
    assert report["counts"]["splines"] >= 1
    assert report["chi2"] > 0
    assert report["lost_scans"] == []
    assert report["range_noise"]["estimated"] == pytest.approx(0.012, rel=0.3)
    assert main(["run", str(simulated), "--out", str(tmp_path / "o"), "--config", str(results / "report.json")]) == 0
    again = json.loads((tmp_path / "o" / "report.json").read_text())
    assert again["configuration"] == report["configuration"]
    assert (tmp_path / "o" / "map.svg").read_text() == (results / "map.svg").read_text()


def test_evaluate_against_the_truth(results: Path, simulated: Path, capsys: pytest.CaptureFixture[str]) -> None:
    truth = simulated.with_name("three.truth.tum")
    assert main(["evaluate", str(results), "--reference", str(truth), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["reference"]
    assert figures["outside_trajectory"] == 0
    assert figures["ate_m"]["mean"] < 0.05


def test_evaluate_measures_the_map_against_its_log(
    results: Path, simulated: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", str(results), "--log", str(simulated), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    report = json.loads((results / "report.json").read_text())
    assert set(figures) == {"crispness", "held_out", "map", "run"}
    assert 0.002 < figures["crispness"]["rms_within_5cm_m"] < 0.02 and figures["crispness"]["share_within_3cm"] > 0.9
    assert figures["held_out"]["beams"] < figures["crispness"]["beams"]
    assert figures["map"]["control_points"] == report["counts"]["control_points"]
    assert 0.0 <= figures["map"]["double_walls_m"] < 0.1 * figures["map"]["spline_metres"]
    assert figures["map"]["bytes"] < figures["map"]["grid_bytes"] and figures["map"]["grid_bytes_gzip"] > 0
    assert figures["run"]["seconds"] == report["seconds"]
    assert main(["evaluate", str(results), "--log", str(simulated)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if not line.startswith(" ")] == [
        "crispness",
        "held",
        "map",
        "double",
        "size",
        "run",
    ]


def test_evaluate_without_a_log_still_tells_size_and_cost(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", str(results), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert set(figures) == {"map", "run"} and figures["map"]["grid_bytes_gzip"] is None


def test_evaluate_refuses_another_log(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "is not the log that results was made from" in complaint(
        capsys, "evaluate", results, "--log", SAMPLES / "office.log.gz"
    )
    assert "nowhere.log: there is no such log" in complaint(capsys, "evaluate", results, "--log", "nowhere.log")


def test_evaluate_prints_both_definitions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "trajectory.tum").write_text("0 0 0 0 0 0 0 1\n1 10 0.3 0 0 0 0.0099998 0.99995\n")
    (tmp_path / "a.relations").write_text("0 1 10 0 0 0 0 0\n0 7 1 1 0 0 0 0\n")
    assert main(["evaluate", str(tmp_path), "--relations", str(tmp_path / "a.relations")]) == 0
    printed = capsys.readouterr().out
    assert "1 of 2 scored" in printed
    assert "1: a stamp lies outside the time of the trajectory" in printed
    assert re.search(r"0\.3000 ± 0\.0000 m.*Kümmerle", printed)
    assert re.search(r"0\.1000 ± 0\.0000 m.*Cartographer", printed)
    assert "1.1459 ± 0.0000 °" in printed


# -- refusals ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["run", "nowhere.log", "--out", "o"], "there is no log nowhere.log; the samples are"),
        (["run", "three_splines", "--out", "o", "--backend", "magic"], "magic"),
        (["run", "three_splines", "--out", "o", "--model", "magic"], "magic"),
        (["run", "three_splines", "--out", "o", "--config", "c.toml"], "there is no configuration file c.toml"),
        (["view", "nowhere.log"], "there is no log nowhere.log"),
        (["evaluate", "nowhere"], "evaluate needs a folder of results, or --relations FILE or"),
        (["evaluate", "nowhere", "--log", "x"], "--log goes with a folder of results that holds a map"),
        (["evaluate", "nowhere", "--relations", "r"], "nowhere: is not a readable trajectory"),
        (["simulate", "atlantis", "--out", "a.log"], "atlantis"),
        (["simulate", "three_splines", "--out", "a.doc"], "a.doc"),
        (["simulate", "--out", "a.log"], "simulate needs either a world or --from-map DIR"),
        (["simulate", "office", "--from-map", "x", "--out", "a.log"], "simulate needs either a world or --from-map"),
        (["simulate", "office", "--log", "x", "--out", "a.log"], "--log goes with --from-map"),
        (["simulate", "--from-map", "nowhere", "--out", "a.log"], "nowhere: is not a folder with the results of a run"),
        (["simulate", "--from-map", "x", "--resolution", "1", "--out", "a.log"], "--resolution goes with a world"),
    ],
)
def test_a_mistake_is_one_sentence(
    words: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert sentence in complaint(capsys, *words)


def test_a_key_that_the_configuration_does_not_know(
    tmp_path: Path, simulated: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "c.toml").write_text("sped = 1\n")
    sentence = complaint(capsys, "run", simulated, "--out", tmp_path / "o", "--config", tmp_path / "c.toml")
    assert "the configuration has no sped; known:" in sentence


def test_a_file_that_is_no_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "noise.log").write_bytes(bytes(range(256)) * 20)
    assert "noise.log" in complaint(capsys, "run", tmp_path / "noise.log", "--out", tmp_path / "o")
    assert not (tmp_path / "o").exists()


# -- from outside ------------------------------------------------------------------------------------------------


def test_interrupting_a_run_ends_it_with_a_sentence(tmp_path: Path) -> None:
    run = subprocess.Popen([*COMMAND, "run", "office", "--out", str(tmp_path / "o")], stderr=subprocess.PIPE, text=True)
    assert run.stderr is not None
    first = run.stderr.readline()
    run.send_signal(signal.SIGINT)
    rest = run.stderr.read()
    assert run.wait(60) == 130
    assert "%" in first
    assert "Traceback" not in rest
    assert rest.splitlines()[-1].startswith("splinescope: ")
    assert not (tmp_path / "o" / "map.json").exists()


def test_view_prints_its_address_and_serves_the_page(simulated: Path, tmp_path: Path) -> None:
    view = subprocess.Popen(
        [*COMMAND, "view", str(simulated), "--no-browser", "--port", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    try:
        assert view.stdout is not None
        address = next(found for line in view.stdout if (found := re.search(r"http://127\.0\.0\.1:\d+", line)))
        with urllib.request.urlopen(address.group(0), timeout=20) as page:
            text = gzip.decompress(page.read()) if page.headers["Content-Encoding"] == "gzip" else page.read()
        assert "<title>SplineScope</title>" in text.decode()
    finally:
        view.send_signal(signal.SIGINT)
        view.wait(30)
