"""Everything the library raises on purpose: one base, one subclass per concern, each a sentence for a person."""

from __future__ import annotations

from pathlib import Path


class SplineSlamError(Exception):
    """Base of every error raised on purpose; its text is one clear sentence."""


class LogError(SplineSlamError):
    """A log cannot be read: `intel.log:214: FLASER announces 181 readings, found 180`."""

    def __init__(self, path: str | Path, rule: str, line: int | None = None) -> None:
        place = f"{Path(path).name}:{line}" if line is not None else Path(path).name
        super().__init__(f"{place}: {rule}")


class GeometryError(SplineSlamError):
    """A curve or a fit is asked for something its numbers do not allow."""


class ConfigError(SplineSlamError):
    """A configuration names something unknown or a value outside its range."""


class SolverError(SplineSlamError):
    """The optimiser cannot continue, and why."""


class LocalMapError(SplineSlamError):
    """Local maps to be joined cannot be read: `maps.npz: P3 is not symmetric`."""

    def __init__(self, path: str | Path, rule: str) -> None:
        super().__init__(f"{Path(path).name}: {rule}")


class EditError(SplineSlamError):
    """An edit by hand makes no sense where it is to be made, or edits cannot be read."""


class Cancelled(SplineSlamError):
    """A long job was stopped by its user; what was done before stands."""


def as_sentence(text: str) -> str:
    """What is wrong, as a message of its own: with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:]}."
