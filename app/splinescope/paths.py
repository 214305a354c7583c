"""Where the files that come with the program are: inside the installed package, else in the repository."""

from __future__ import annotations

from pathlib import Path

from bspline_slam.errors import SplineSlamError

PACKAGE = Path(__file__).parent
REPOSITORY = PACKAGE.parents[1]
LOG_SUFFIXES = (".log", ".log.gz", ".clf", ".mcap", ".bag")


def static_folder() -> Path:
    """The page's own files: title, icon, style, script."""
    return _folder("static")


def sample_folder() -> Path:
    """The logs that come with the program."""
    return _folder("sample_logs")


def sample_logs() -> dict[str, Path]:
    """The sample logs by file name, sorted; the first of them with a name is what that name alone means."""
    found = (path for path in sorted(sample_folder().iterdir()) if path.name.endswith(LOG_SUFFIXES))
    return {path.name: path for path in found}


SAMPLE = "office"
"""The log that a first visitor sees."""


def find_log(given: str) -> Path:
    """A path as it was given, or the sample log of that name (`office`, `office.mcap`)."""
    path = Path(given).expanduser()
    if path.exists():
        return path
    samples = sample_logs()
    for name, sample in samples.items():
        if given in (name, name.partition(".")[0]):
            return sample
    names = ", ".join(dict.fromkeys(name.partition(".")[0] for name in samples))
    raise SplineSlamError(f"there is no log {given}; the samples are {names}")


def _folder(name: str) -> Path:
    return next((root / name for root in (PACKAGE, REPOSITORY) if (root / name).is_dir()), PACKAGE / name)
