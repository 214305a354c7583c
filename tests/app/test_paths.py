"""Where sample logs and static files are found."""

from __future__ import annotations

from pathlib import Path

import pytest

from bspline_slam.errors import SplineSlamError
from splinescope import paths


@pytest.fixture
def samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "package" / "sample_logs"
    folder.mkdir(parents=True)
    for name in ("office.log.gz", "office.mcap", "office.truth.tum", "README.md", "three_splines.log"):
        (folder / name).touch()
    monkeypatch.setattr(paths, "PACKAGE", tmp_path / "package")
    return folder


def test_the_repository_has_both_folders() -> None:
    assert (paths.static_folder() / "page.js").is_file()
    assert paths.sample_folder().is_dir()


def test_the_package_comes_before_the_repository(samples: Path) -> None:
    assert paths.sample_folder() == samples


def test_only_logs_are_samples(samples: Path) -> None:
    assert list(paths.sample_logs()) == ["office.log.gz", "office.mcap", "three_splines.log"]


def test_a_log_is_found_by_path_by_file_name_and_by_sample_name(samples: Path, tmp_path: Path) -> None:
    own = tmp_path / "office"
    assert paths.find_log("office") == samples / "office.log.gz"
    assert paths.find_log("office.mcap") == samples / "office.mcap"
    own.touch()
    assert paths.find_log(str(own)) == own


@pytest.mark.usefixtures("samples")
def test_an_unknown_log_is_answered_with_the_names_of_the_samples() -> None:
    with pytest.raises(SplineSlamError, match=r"no log atrium; the samples are office, three_splines"):
        paths.find_log("atrium")
