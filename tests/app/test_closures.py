"""The list of loop closures: what is on which page, what a row says, and where a click on it leads."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from app import views
from app.inline import deliver, session_with, stand_in
from app.logs import corridor_log
from bspline_slam import se2
from bspline_slam.front_end.loop_closure import LoopClosure
from splinescope import commands as ask
from splinescope.closures import ROWS, ClosurePage, Which, chosen, moves, pages
from splinescope.inspector import describe
from splinescope.palette import DARK
from splinescope.panels.closures import distance, label, shown
from splinescope.scene.detail import OVERVIEW
from splinescope.scene.map_layers import pointed_at
from splinescope.typeset import typeset
from splinescope.view import Selection


def closure(earlier: int, scan: int, accepted: bool = True, measured: np.ndarray | None = None) -> LoopClosure:
    reason = "correlation 0.71" if accepted else "correlation <0.31> is below 0.55"
    where = np.zeros(3) if measured is None else measured
    return LoopClosure(earlier, scan, where, np.eye(3), 0.71 if accepted else 0.31, 0.8, accepted, reason)


MANY = tuple(closure(k % 5, 50 - k, accepted=k % 3 > 0) for k in range(30))


def test_every_closure_is_on_one_page() -> None:
    numbers = chosen(MANY, Which.ALL)
    assert sorted(numbers) == list(range(30))
    assert [MANY[number].scan for number in numbers] == sorted(closure.scan for closure in MANY)
    listed = [shown(MANY, None, ClosurePage(Which.ALL, page), None) for page in range(pages(30))]
    told = [int(number) for parts in listed for number in dict.fromkeys(re.findall(r'data-number="(\d+)"', str(parts)))]
    assert told == numbers


@pytest.mark.parametrize(("which", "count"), [(Which.ACCEPTED, 20), (Which.REJECTED, 10)])
def test_a_choice_lists_only_its_own(which: Which, count: int) -> None:
    numbers = chosen(MANY, which)
    assert len(numbers) == count
    assert {MANY[number].accepted for number in numbers} == {which is Which.ACCEPTED}


def test_pages_are_turned_within_the_list() -> None:
    page = ClosurePage(Which.REJECTED, 1)
    assert page.turned(1, 2) == page
    assert page.turned(-1, 2).number == page.turned(-5, 2).number == 0
    assert ClosurePage().turned(1, 0).number == 0
    assert [pages(count) for count in (0, 1, ROWS, ROWS + 1)] == [0, 1, 1, 2]


def test_a_row_tells_scores_and_why_it_was_rejected() -> None:
    text = "".join(shown((closure(3, 1200, False),), np.array([[0.021, 0.01]]), ClosurePage(), 0))
    for told in ("3 – 1,200", "0.31", "80%", "21 mm, 0.6°", "✕ rejected"):
        assert typeset(told) in text
    assert "Correlation &lt;0.31&gt; is below 0.55." in text
    assert 'class="lead open on"' in text
    assert "71" not in "".join(shown((closure(3, 4),), None, ClosurePage(), None)).partition("0.71")[2]


def test_an_empty_list_says_why() -> None:
    assert "No place" in shown((), None, ClosurePage(), None)[0]
    assert "None is rejected" in shown((closure(0, 9),), None, ClosurePage(Which.REJECTED), None)[0]
    assert label(()) == "Loop closures" and label(MANY) == "Loop closures: 20 of 30 accepted"
    assert [distance(metres) for metres in (0.0214, 1.5)] == ["21 mm", "1.50 m"]


def test_a_closure_that_holds_moves_nothing() -> None:
    rng = np.random.default_rng(3)
    poses, keys = rng.normal(0.0, 2.0, (4, 3)), np.array([0, 5, 9, 30])
    holds = closure(5, 30, measured=se2.between(poses[1], poses[3]))
    off = closure(0, 9, measured=se2.compose(se2.between(poses[0], poses[2]), np.array([0.3, 0.4, -0.2])))
    assert moves((holds, off), keys, poses) == pytest.approx(np.array([[0.0, 0.0], [0.5, 0.2]]), abs=1e-9)
    assert moves((), keys, poses).shape == (0, 2)


def test_a_row_leads_to_its_scan_and_selects_the_tie(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = corridor_log(np.random.default_rng(4), 30)
    stand_in(monkeypatch, drive)
    session, inline = session_with(drive)
    deliver(session, inline)
    assert session.findings.snapshot is not None
    session.findings.snapshot = replace(session.findings.snapshot, loop_closures=(closure(0, 20), closure(5, 25)))
    session.apply(ask.ShowClosure(1))
    assert (session.cursor, session.selection) == (25, Selection("closure", 1))
    for gone in (2, -1):
        session.apply(ask.ShowClosure(gone))
        assert session.cursor == 25
    session.apply(ask.LeafThrough(ClosurePage(Which.REJECTED, 2)))
    assert session.closure_page.number == 2


def test_the_selected_tie_is_drawn_and_described() -> None:
    world = views.map_view(np.random.default_rng(5))
    accepted = next(number for number, loop in enumerate(world.loop_closures) if loop.accepted)
    rejected = next(number for number, loop in enumerate(world.loop_closures) if not loop.accepted)
    drawn = [len(pointed_at(world, Selection("closure", number), DARK, OVERVIEW)) for number in (accepted, rejected)]
    assert drawn[1] == drawn[0] + 1 > 2, "that of a rejected closure is broken"
    assert len(pointed_at(world, Selection("closure", 999), DARK, OVERVIEW)) == 0
    found = describe(Selection("closure", rejected), None, world, {})
    assert found.sentence == "Rejected: seen again."
    assert "not in the map" in describe(Selection("closure", 999), None, world, {}).sentence
