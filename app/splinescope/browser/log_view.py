"""How one log was looked at: kept from one visit to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from splinescope.browser.values import Place
from splinescope.view import Piece, Selection


@dataclass(frozen=True, slots=True)
class LogView:
    """The scan under the cursor (None: the newest processed one), the place seen (None: the whole map), what is
    selected, and the open tab (empty: the first)."""

    cursor: int | None = None
    place: Place | None = None
    selection: Selection | None = None
    tab: str = ""

    @staticmethod
    def from_json(told: Any) -> LogView:
        """What was kept; what is missing or makes no sense stays as on a first visit."""
        if not isinstance(told, dict):
            return LogView()
        cursor, tab = told.get("cursor"), told.get("tab")
        return LogView(
            cursor if isinstance(cursor, int) and cursor >= 0 else None,
            place_from(told.get("place")),
            _selection(told.get("selection")),
            tab if isinstance(tab, str) else "",
        )


def place_from(told: Any) -> Place | None:
    """Three numbers as a place; None where they are none, or its scale is not above zero."""
    if not isinstance(told, (list, tuple)) or len(told) != 3:
        return None
    try:
        x, y, scale = (float(number) for number in told)
    except (TypeError, ValueError):
        return None
    return (x, y, scale) if math.isfinite(x) and math.isfinite(y) and 0.0 < scale < 1e3 else None


def _pieces(told: Any) -> tuple[Piece, ...]:
    found = []
    for piece in told if isinstance(told, list) else ():
        match piece:
            case [int(segment), int(first), int(last)]:
                found.append((segment, first, last))
    return tuple(found)


def _selection(told: Any) -> Selection | None:
    match told:
        case {"kind": str(kind), "id": int(number), "sub": int(sub)}:
            return Selection(kind, number, sub, _pieces(told.get("pieces")))
    return None
