"""The lists of the Edit tab, as HTML parts: what is selected, the preview, the history, the explanation."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from bspline_slam.edits.explain import Explanation, Fate
from bspline_slam.edits.history import Accepted, History
from splinescope import table
from splinescope.edits.editing import Editing
from splinescope.edits.subject import NOTHING
from splinescope.session import Session

STATE, SWITCH, WORST, DOUBT = "edit-state", "edit-switch", "edit-worst", "doubt"
"""Names of rows in what the page tells of clicks."""
HINT = (
    "Select a segment of a key scan, a spline, a key pose or a loop closure; drag with Shift to select many pieces. "
    "What you propose is drawn dashed over the map before you accept it."
)
ON_ITS_WAY = "The exact map is on its way; what you see is nearly it."


def selected(session: Session) -> list[str]:
    """What an edit would be about, where that is more than what is selected."""
    found, chosen = session.subject, session.target
    if found is NOTHING:
        return [table.paragraph(HINT, "dim")]
    said = ""
    if found.piece is not None and len(found.pieces) > 1:
        piece, number = found.piece, found.pieces.index(found.piece) + 1
        said = f"Piece {number} of {len(found.pieces)}: beams {piece.first}–{piece.last}. "
    if chosen is not None:
        others = ", ".join(str(other) for other in found.targets if other != chosen)
        said += f"Target: spline {chosen}" + (f"; others near it: {others}." if others else ".")
    return [table.paragraph(said.strip())] if said else []


def proposed(editing: Editing) -> list[str]:
    """What is proposed, and what it would do."""
    parts = [table.paragraph(editing.picking.value, "ask")] if editing.picking is not None else []
    if editing.draft is not None:
        draft = editing.draft
        said = draft.verdict or (
            "Shift it with Ctrl and the arrow keys, turn it with Alt and the arrow keys; or click a point of it and "
            "then where that belongs in the map, twice."
        )
        if draft.marks:
            said = ("Click where that point belongs in the map.", "Click another point of the ghost scan.")[
                (len(draft.marks) + 1) % 2
            ]
        parts += [table.heading(f"Scan {draft.scan} laid over scan {draft.earlier}"), table.paragraph(said)]
    proposal = editing.proposal
    if proposal is None:
        return parts
    parts.append(table.heading(proposal.name))
    preview = proposal.preview
    if preview is None:
        return [*parts, table.paragraph("Finding out what it would do …", "dim")]
    if preview.refusal is not None:
        return [*parts, table.paragraph(f"It cannot be made: {preview.refusal}", "bad")]
    return [*parts, table.pairs(preview.rows)]


def history(history: History) -> list[str]:
    """Every action, the newest first, those undone marked; a click on a row goes to the state after it, one on its
    state switches it off or on."""
    if not history.entries:
        return [table.paragraph("No edit was made yet.", "dim")]
    states = history.states
    rows = [(0, ("0 As the estimator made it", ""), "")]
    for place, entry in enumerate(history.entries, 1):
        undone = place > history.cursor
        if isinstance(entry, Accepted):
            state = "undone" if undone else switch(entry.number, states[entry.number])
            when = datetime.fromtimestamp(entry.action.time).strftime("%H:%M")
            rows.append((place, (f"{place} {entry.action.name} ({when})", state), ""))
        else:
            words = f"Switch action {_place_of(history, entry.number)} {'on' if entry.on else 'off'}"
            rows.append((place, (f"{place} {words}", "undone" if undone else ""), ""))
    return [f'<div class="past">{table.leading(STATE, ("Action", ""), rows[::-1], selected=history.cursor)}</div>']


def switch(number: int, on: bool) -> table.Html:
    """The state of an action in force; pressed, it changes to the other."""
    return table.lead(SWITCH, number, "● on" if on else "○ off")


def _place_of(history: History, number: int) -> int:
    """Where an accepted action stands in the list."""
    places = {entry.number: place for place, entry in enumerate(history.entries, 1) if isinstance(entry, Accepted)}
    return places.get(number, 0)


SIGNS = {Fate.FOLLOWED: "✓", Fate.OUTVOTED: "✕", Fate.SKIPPED: "–"}


def verdict(editing: Editing) -> list[str]:
    """What became of the last edit in force, in one sentence."""
    told = editing.explanation
    if editing.making:
        return [table.paragraph(ON_ITS_WAY, "dim")]
    if told is None or not told.outcomes:
        return []
    last, change = told.outcomes[-1], sum(told.after.values()) - sum(told.before.values())
    away = 1000 * float(told.moves.max(initial=0.0))
    all_in_all = f"All in all the cost changes by {change:+,.1f} and a pose moves by {away:.1f} mm at most."
    if (fewer := told.beams[0] - told.beams[1]) > 0:
        all_in_all += f" {fewer:,} beams fewer count, and what is left out costs nothing."
    return [table.paragraph(f"{SIGNS[last.fate]} The last one was {last.fate.value}. {last.sentence} {all_in_all}")]


DOUBTS_SHOWN = 8
"""Rows of the queue of doubts that are listed, around the one looked at."""


def doubted(editing: Editing) -> list[str]:
    """The doubtful decisions around the one looked at, or why there are none."""
    doubts = editing.doubts
    if editing.no_doubts is not None:
        return [table.paragraph(editing.no_doubts, "dim")]
    first = max(min((doubts.at or 0) - 2, len(doubts.queue) - DOUBTS_SHOWN), 0)
    rows = [
        (number, (f"scan {doubt.scan}", f"{doubt.score:.2f}"), doubt.sentence)
        for number, doubt in enumerate(doubts.queue[first : first + DOUBTS_SHOWN], first)
    ]
    place = "" if doubts.at is None else f"; number {doubts.at + 1} is shown"
    return [
        table.paragraph(
            f"{len(doubts.queue)} close decisions{place}. A doubt of 1 is a coin toss on which much hangs.", "dim"
        ),
        table.leading(DOUBT, ("Decision", "Doubt"), rows, selected=doubts.at),
    ]


def explanation(told: Explanation | None, names: tuple[str, ...]) -> list[str]:
    """What the solver did with the edits in force."""
    if told is None:
        return []
    return [*_fates(told, names), *_costs(told), *_moves(told), *_worst(told)]


def _fates(told: Explanation, names: tuple[str, ...]) -> Iterator[str]:
    yield table.heading("What became of each edit")
    yield table.explained(
        (name, f"{SIGNS[outcome.fate]} {outcome.fate.value}", outcome.sentence)
        for name, outcome in zip(names, told.outcomes, strict=False)
    )


def _costs(told: Explanation) -> Iterator[str]:
    rows = [
        (kind, f"{told.before[kind]:,.1f}", f"{told.after[kind]:,.1f}", f"{told.after[kind] - told.before[kind]:+,.1f}")
        for kind in told.before
        if max(told.before[kind], told.after[kind]) > 0
    ]
    before, after = sum(told.before.values()), sum(told.after.values())
    rows.append(("all", f"{before:,.1f}", f"{after:,.1f}", f"{after - before:+,.1f}"))
    counted, count = told.beams
    rows.append(("beams that count", f"{counted:,}", f"{count:,}", f"{count - counted:+,}"))
    yield table.heading("Cost by kind of factor")
    yield table.table(("", "before", "after", "change"), rows, numbers=(1, 2, 3))


def _moves(told: Explanation) -> Iterator[str]:
    moved = int(np.count_nonzero(told.moves > 1e-3))
    largest = 1000 * float(told.moves.max(initial=0.0))
    yield table.paragraph(
        f"{moved:,} of {len(told.moves):,} key poses moved by more than 1 mm, the farthest by {largest:.1f} mm; lines "
        "at the poses show where to, longer than they are."
    )


def _worst(told: Explanation) -> Iterator[str]:
    rows = []
    for number, worst in enumerate(told.worst):
        place = (
            f"segment {worst.segment}, spline {worst.spline}" if worst.segment is not None else f"scan {worst.other}"
        )
        cells = (f"scan {worst.scan}", f"{worst.size:.1f} σ", f"{1000 * worst.metres:.0f} mm")
        rows.append((number, cells, f"{worst.kind}: {place}"))
    yield table.heading("The ten worst residuals")
    yield table.leading(WORST, ("", "RMS", ""), rows)
