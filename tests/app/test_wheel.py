"""The wheel: everything it needs is inside, and it works from another folder."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


def python(*arguments: str | Path, cwd: Path = REPOSITORY, **environment: str) -> str:
    """What a Python of its own prints."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=cwd,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    python("-m", "pip", "wheel", ".", "--no-deps", "--no-build-isolation", "--quiet", "--wheel-dir", folder)
    return next(folder.glob("splinescope-*.whl"))


@pytest.fixture(scope="module")
def unpacked(wheel: Path) -> Path:
    """The wheel as an installer would lay it out, without the repository on the path."""
    folder = wheel.parent / "installed"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def test_sample_logs_and_static_files_are_inside(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for folder in ("static", "sample_logs"):
        inside = (path for path in (REPOSITORY / folder).rglob("*") if path.is_file())
        assert {f"splinescope/{path.relative_to(REPOSITORY)}" for path in inside} <= names
    assert {"splinescope/py.typed", "bspline_slam/py.typed"} <= names
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_nothing_else_is_inside(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {"splinescope", "bspline_slam"}
    assert not any(name.endswith((".pyc", ".nbi", ".nbc")) for name in names)


def test_it_runs_from_another_folder(unpacked: Path, tmp_path: Path) -> None:
    where = python("-c", "import splinescope; print(splinescope.__file__)", cwd=tmp_path, PYTHONPATH=str(unpacked))
    assert Path(where.strip()).is_relative_to(unpacked)
    python(
        *("-m", "splinescope", "simulate", "three_splines", "--out", "three.log"),
        cwd=tmp_path,
        PYTHONPATH=str(unpacked),
    )
    assert (tmp_path / "three.log").stat().st_size > 1000


def test_it_finds_its_samples_and_its_page(unpacked: Path, tmp_path: Path) -> None:
    ask = "from splinescope import paths; print(paths.find_log('office')); print(paths.static_folder())"
    found = python("-c", ask, cwd=tmp_path, PYTHONPATH=str(unpacked)).splitlines()
    assert all(Path(path).is_relative_to(unpacked) for path in found)
    assert len(found) == 2
