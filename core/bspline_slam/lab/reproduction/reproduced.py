"""What the reproduction of one figure leaves behind: rows of the table "paper / ours", data, files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

NOT_GIVEN = "–"
"""The paper shows a picture and no number."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: which figure, which quantity, what the paper prints and what came out here."""

    figure: str
    quantity: str
    paper: str
    ours: str


@dataclass(frozen=True, slots=True)
class Reproduced:
    """One figure done again: its rows and the files that were written."""

    rows: tuple[Row, ...]
    files: tuple[Path, ...]


def write_data(stem: Path, data: Mapping[str, Any]) -> Path:
    """Everything that a figure shows, as JSON beside it; arrays become nested lists."""
    path = stem.with_suffix(".json")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(_plain(data), indent=1) + "\n", encoding="utf-8")
    return path


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return np.round(value.astype(float), 9).tolist()
    if isinstance(value, np.generic):
        return value.item()
    return value
