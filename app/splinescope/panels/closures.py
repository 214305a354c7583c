"""The loop closures: places that were seen again, with their scores, the verdict on each and its reason."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from jaxtyping import Float

from bspline_slam.errors import as_sentence
from bspline_slam.front_end.loop_closure import LoopClosure
from splinescope import table
from splinescope.closures import ROWS, ClosurePage, Which, chosen, pages
from splinescope.commands import LeafThrough
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post, on_change
from splinescope.session import Session

TITLE = "Loop closures"
WAYS: Buttons = {"Page before": "closures-back", "Next page": "closures-next"}
ROW = "closure"
"""Name of a row in what the page tells of clicks."""
SIGNS = {"accepted": "✓", "rejected": "✕", "waiting": "…"}
HEADERS = ("Scans", "Score", "Inliers", "Off by", "Verdict")
MEANING = (
    "Each compares a key scan with a place seen long before: the correlation, the share of beams on the earlier map, "
    "and how far the final map is from what the closure says. Click a row to see the tie in the map."
)


class ClosuresPanel:
    """A page of the list, the choice of what is in it, and the way to other pages."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._drawn: tuple[object, ...] = ()
        self._folder = gui.add_folder(TITLE, expand_by_default=False)
        with self._folder:
            self._which = gui.add_dropdown("Show", tuple(which.value for which in Which))
            self._text = gui.add_html("")
        on_change(self._which, lambda: post(LeafThrough(ClosurePage(Which(self._which.value)))))

    def refresh(self, session: Session) -> None:
        snapshot, quality = session.findings.snapshot, session.findings.quality
        closures = snapshot.loop_closures if snapshot is not None else ()
        selected = session.selection.id if session.selection is not None and session.selection.kind == ROW else None
        state = (closures, quality, session.closure_page, selected)
        if state == self._drawn:
            return
        self._drawn, page = state, session.closure_page
        more = pages(len(chosen(closures, page.which))) > 1
        self._folder.label = label(closures)
        self._which.value = page.which.value
        listed = shown(closures, quality.moves if quality else None, page, selected)
        self._text.content = table.block(*listed, *([action_row(session, WAYS)] if more else []))


def label(closures: Sequence[LoopClosure]) -> str:
    """The heading, with how many of them were accepted."""
    accepted = sum(closure.accepted for closure in closures)
    return f"{TITLE}: {accepted:,} of {len(closures):,} accepted" if closures else TITLE


def shown(
    closures: Sequence[LoopClosure], moves: Float[np.ndarray, "c 2"] | None, page: ClosurePage, selected: int | None
) -> list[str]:
    """One page of the list as HTML parts."""
    numbers = chosen(closures, page.which)
    if not numbers:
        none = "No place has been compared with an earlier one." if not closures else f"None is {page.which.value}."
        return [table.paragraph(none)]
    mine = numbers[ROWS * page.number : ROWS * (page.number + 1)]
    rows = [(number, *row(closures[number], None if moves is None else moves[number])) for number in mine]
    place = f"{ROWS * page.number + 1:,} to {ROWS * page.number + len(mine):,} of {len(numbers):,}"
    return [
        table.paragraph(MEANING, "dim"),
        table.leading(ROW, HEADERS, rows, selected=selected),
        table.paragraph(place, "dim"),
    ]


def row(closure: LoopClosure, move: Float[np.ndarray, "2"] | None) -> tuple[tuple[str, ...], str]:
    """The cells of one closure, and why it was rejected."""
    off = "–" if move is None else f"{distance(move[0])}, {np.degrees(move[1]):.1f}°"
    cells = (
        f"{closure.earlier:,} – {closure.scan:,}",
        f"{closure.score:.2f}",
        f"{closure.inliers:.0%}",
        off,
        f"{SIGNS[closure.verdict]} {closure.verdict}",
    )
    return cells, "" if closure.accepted else as_sentence(closure.reason)


def distance(metres: float) -> str:
    """Millimetres, from a metre on metres."""
    return f"{1000 * metres:.0f} mm" if metres < 1.0 else f"{metres:.2f} m"
