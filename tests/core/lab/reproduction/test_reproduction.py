"""The paper's experiments: what must hold of them whatever the noise, and that each writes its files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bspline_slam.errors import ConfigError
from bspline_slam.lab.reproduction import invariance, relations, reproduce, sight, uncertainty
from bspline_slam.logs import open_log


def test_two_places_give_the_same_control_points() -> None:
    views = invariance.two_views()
    assert views.mean_square_error < 2.4e-3
    assert views.differences.max() < 0.02


def test_every_further_term_of_the_covariance_covers_more() -> None:
    shares = [share.mean() for share in uncertainty.coverage(30, np.random.default_rng(1)).by_model.values()]
    assert shares[0] < shares[1] < shares[2]


def test_turning_the_frame_turns_the_ellipses() -> None:
    seen = sight.observe(sight.scan_curve(sight.REFERENCE, sight.FIRST_POSE, sight.COARSE))
    back = seen.seen_from(sight.SECOND_POSE)
    assert np.allclose(np.linalg.eigvalsh(seen.blocks), np.linalg.eigvalsh(back.blocks))
    assert not np.allclose(seen.blocks, back.blocks)


def test_the_cases_are_decided_as_they_were_made() -> None:
    shares = relations.right_decisions(5, np.random.default_rng(2))
    assert min(shares.values()) == 1.0


@pytest.mark.parametrize(
    ("figure", "stems"), [(1, {"figure_1"}), (7, {"figure_5", "figure_6", "figure_7"}), (8, {"figure_8"})]
)
def test_a_figure_is_drawn_twice_and_its_data_written(figure: int, stems: set[str], tmp_path: Path) -> None:
    (result,) = reproduce(tmp_path, figure)
    assert {path.stem for path in tmp_path.glob("*.svg")} == {path.stem for path in tmp_path.glob("*.png")} == stems
    assert all(path.stat().st_size > 0 for path in result.files)
    assert all(json.loads(path.read_text()) for path in tmp_path.glob("*.json"))
    assert result.rows


def test_a_recorded_log_becomes_a_small_map(tmp_path: Path) -> None:
    log = open_log(Path(__file__).parents[4] / "sample_logs" / "three_splines.log.gz")
    (result,) = reproduce(tmp_path, 9, log)
    assert {path.name for path in result.files} == {"figure_9.svg", "figure_9.png", "figure_9.json"}
    data = json.loads((tmp_path / "figure_9.json").read_text())
    off = np.array(data["poses"]) - np.array(data["poses_of_whole_log"])
    assert len(off) > 5 and np.hypot(off[:, 0], off[:, 1]).max() < 0.5
    assert {len(points) for points in data["control_points"].values()} == {13}


def test_figure_9_without_a_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="figure 9 is made from a recorded log"):
        reproduce(tmp_path, 9)


def test_an_unknown_figure_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="there is no figure 12 to reproduce: choose one of 1, 2"):
        reproduce(tmp_path, 12)
