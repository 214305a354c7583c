"""Compare: every result so far; which one is shown, which one is laid over it, and how the two differ."""

from __future__ import annotations

import numpy as np
import viser

from splinescope import table
from splinescope.commands import CompareWith, ShowResult
from splinescope.comparison import FIGURES, choices, differences, figures, largest_pose_difference
from splinescope.panels.action_row import Buttons, action_row
from splinescope.panels.panel import Post, on_change
from splinescope.result import Result, Results
from splinescope.session import Session

NOTHING: str = "no other"
WAYS: Buttons = {"Largest difference": "result-apart", "Swap the two": "result-swap", "Delete it": "result-delete"}
NOTES = (
    "ATE: error of the positions against the truth. Pose NEES / 3: errors measured by the covariances; 1 is honest, "
    "more is overconfident."
)


class ComparePanel:
    """Two choices, what can be done with them, and the table of differences."""

    def __init__(self, gui: viser.GuiApi, post: Post) -> None:
        self._post = post
        self._shown = gui.add_dropdown("Shown (solid)", (NOTHING,))
        self._compared = gui.add_dropdown("Over it (dashed)", (NOTHING,))
        self._text = gui.add_html("")
        on_change(self._shown, lambda: self._show(self._shown.value))
        on_change(self._compared, lambda: post(CompareWith(number_of(self._compared.value))))

    def refresh(self, session: Session) -> None:
        results = session.results
        labels = tuple(result.label for result in results.all)
        _offer(self._shown, labels or (NOTHING,), results.shown)
        _offer(self._compared, (NOTHING, *labels), results.compared)
        self._text.content = table.block(action_row(session, WAYS), *report(results))
        self._shown.disabled = self._compared.disabled = session.busy

    def _show(self, label: str) -> None:
        number = number_of(label)
        if number is not None:
            self._post(ShowResult(number))


def _offer(dropdown: viser.GuiDropdownHandle[str], labels: tuple[str, ...], chosen: Result | None) -> None:
    if dropdown.options != labels:
        dropdown.options = labels
    dropdown.value = NOTHING if chosen is None else chosen.label


def number_of(label: str) -> int | None:
    """The number with which the label of a result begins; None where no result is meant."""
    number = label.partition(":")[0]
    return int(number) if number.isdigit() else None


def report(results: Results) -> list[str]:
    """The table of figures, with differences where two results are looked at, as HTML parts."""
    shown, compared = results.shown, results.compared
    if shown is None:
        return [table.paragraph("There is no result yet.", "dim")]
    if compared is None:
        rows = [*choices(shown), *zip((figure.name for figure in FIGURES), figures(shown), strict=True)]
        more = "Run again under Estimate to have something to compare." if len(results.all) == 1 else ""
        return [table.pairs(rows), table.paragraph(NOTES, "dim"), table.paragraph(more, "dim")]
    header = ("", f"result {shown.number}", f"result {compared.number}", "difference")
    return [
        f'<div class="two">{table.table(header, rows_of(shown, compared), numbers=(1, 2, 3))}</div>',
        table.paragraph(apart(shown, compared)),
        table.paragraph(NOTES, "dim"),
    ]


def rows_of(shown: Result, compared: Result) -> list[tuple[str, str, str, str]]:
    """What the two were made with, where that differs, and the figures of both with their differences."""
    made = zip(choices(shown), choices(compared), strict=True)
    measured = zip(FIGURES, figures(shown), figures(compared), differences(shown, compared), strict=True)
    return [
        *((name, one, other, "") for (name, one), (_, other) in made if one != other),
        *((figure.name, one, other, more) for figure, one, other, more in measured),
    ]


def apart(shown: Result, compared: Result) -> str:
    """How far the two trajectories lie apart, as a sentence."""
    most = largest_pose_difference(shown, compared)
    if most is None:
        return "The two have no scan in common."
    turned = np.degrees(most.angle)
    return f"Largest pose difference: {1000 * most.distance:.1f} mm and {turned:.2f}° at scan {most.scan:,}."
