"""Hand edits played again without a display: byte for byte what they made, and refusals in a sentence."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bspline_slam.edits.amend import amended
from bspline_slam.edits.edit import FIRST_MADE_BY_HAND, Edit, Forbid, Ignore, MakeNew
from bspline_slam.edits.history import Accept, GoTo, Switch
from bspline_slam.edits.journal import Journal, Origin
from bspline_slam.estimates import marginals
from bspline_slam.export.map_json import map_to_json
from bspline_slam.logs import open_log
from bspline_slam.slam import SlamConfig, Snapshot, run_slam
from splinescope.__main__ import main

LOG = Path(__file__).parents[3] / "sample_logs" / "three_splines.log.gz"


@pytest.fixture(scope="module")
def base() -> Snapshot:
    return run_slam(open_log(LOG)).snapshot


def edits_on(base: Snapshot) -> list[Edit]:
    ids = {spline.id for spline in base.map}
    seen = [a for key in base.observations[5:8] for a in key.associations if a.spline in ids]
    (a, b, c), spline = seen[:3], seen[1].spline
    assert spline is not None
    return [
        Ignore(a.scan, a.segment, a.first, a.last),
        Forbid(b.scan, b.segment, b.first, b.last, spline),
        MakeNew(c.scan, c.segment, c.first, c.last, FIRST_MADE_BY_HAND),
    ]


def journal_with(path: Path, edits: list[Edit], origin: Origin) -> Journal:
    journal = Journal(path, origin)
    for number, edit in enumerate(edits):
        journal.append(Accept(f"edit {number}", 0.0, (edit,)))
    return journal


def test_a_replay_writes_the_very_bytes(base: Snapshot, tmp_path: Path) -> None:
    origin = Origin.of(open_log(LOG), SlamConfig())
    journal = journal_with(tmp_path / "a.edits", edits_on(base), origin)
    journal.append(Switch(1, False, 0.0))
    journal.append(Switch(1, True, 0.0))
    journal.append(GoTo(4))
    journal.close()
    shown = amended(base, journal.history.active, SlamConfig()).snapshot
    assert len(journal.history.active) == 2
    covariances = marginals(shown, splines=[spline.id for spline in shown.map]).splines
    map_to_json(shown.map, covariances, tmp_path / "shown.json")
    assert main(["run", str(LOG), "--edits", str(journal.path), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "map.json").read_bytes() == (tmp_path / "shown.json").read_bytes()
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [one["edit"].split()[0] for one in report["edits"]] == ["Ignore", "Make"]
    assert report["edits_hash"] == journal.history.state_hash


def test_what_is_left_out_is_told(base: Snapshot, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edits: list[Edit] = [Ignore(9999, 0, 0, 5)]
    journal_with(tmp_path / "a.edits", edits, Origin.of(open_log(LOG), SlamConfig())).close()
    assert main(["run", str(LOG), "--edits", str(tmp_path / "a.edits"), "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "0 hand edits are in the map." in printed
    assert "Left out: Ignore beams 0–5 of scan 9999: scan 9999 is no key scan." in printed


@pytest.mark.parametrize(
    ("origin", "more", "complaint"),
    [
        (Origin("/logs/other.log", "abc", {}), [], "the edits belong to another log: other.log"),
        (Origin("a", "abc", {"magic": 1}), [], "no magic"),
        (Origin("a", "abc", {}), ["--backend", "sam"], "leave out --config"),
    ],
)
def test_edits_of_something_else_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], origin: Origin, more: list[str], complaint: str
) -> None:
    journal_with(tmp_path / "a.edits", [], origin).close()
    words = ["run", str(LOG), "--edits", str(tmp_path / "a.edits"), "--out", str(tmp_path / "out"), *more]
    assert main(words) == 2
    assert complaint in capsys.readouterr().err


def test_a_missing_journal_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(LOG), "--edits", str(tmp_path / "no.edits"), "--out", str(tmp_path)]) == 2
    assert "no.edits cannot be read" in capsys.readouterr().err
