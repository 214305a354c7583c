"""Two results side by side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import viser

from app.inline import InlineEstimator, deliver
from splinescope import commands as ask
from splinescope.browser.page import Page
from splinescope.comparison import FIGURES, differences, figures, largest_pose_difference
from splinescope.panels import compare
from splinescope.recipe import Recipe
from splinescope.result import Result, Results
from splinescope.session import Session


@pytest.fixture
def two(finished: tuple[Session, InlineEstimator]) -> tuple[Session, InlineEstimator]:
    """A session with two results of the stand-in, the second 0.1 m beside the first."""
    session, inline = finished
    session.apply(ask.Choose(Recipe(back_end="sam")))
    session.apply(ask.Optimise())
    deliver(session, inline)
    return session, inline


def pair(session: Session) -> tuple[Result, Result]:
    shown, compared = session.results.shown, session.results.compared
    assert shown is not None
    assert compared is not None
    return shown, compared


def test_the_scan_that_differs_most_is_found(two: tuple[Session, InlineEstimator]) -> None:
    shown, compared = pair(two[0])
    poses = compared.snapshot.poses.copy()
    poses[7] += (0.3, 0.4, np.pi)
    moved = replace(compared, snapshot=replace(compared.snapshot, poses=poses))
    most = largest_pose_difference(compared, moved)
    assert most is not None
    assert (most.scan, most.distance, most.angle) == (7, pytest.approx(0.5), pytest.approx(np.pi))
    short = replace(moved, snapshot=replace(moved.snapshot, poses=poses[:5]))
    found = largest_pose_difference(short, shown)
    assert found is not None
    assert found.distance == pytest.approx(0.1)
    assert largest_pose_difference(replace(short, snapshot=replace(short.snapshot, poses=poses[:0])), shown) is None


def test_differences_are_those_of_the_first_from_the_second(two: tuple[Session, InlineEstimator]) -> None:
    shown, compared = pair(two[0])
    assert shown.solution is not None
    slower = replace(shown, solution=replace(shown.solution, seconds=3.0, chi2=1800.0))
    faster = replace(compared, solution=replace(shown.solution, seconds=1.0, chi2=900.0))
    names = [figure.name for figure in FIGURES]
    assert differences(slower, faster)[names.index("time")] == "+2.0 s"
    assert differences(faster, slower)[names.index("time")] == "−2.0 s"
    assert differences(slower, faster)[names.index("χ² / dof")] == "+0.900"
    assert differences(slower, slower)[names.index("time")] == "0.0 s"


def test_what_is_unknown_is_no_number(two: tuple[Session, InlineEstimator]) -> None:
    shown, compared = pair(two[0])
    bare = replace(shown, solution=None, consistency=None)
    unknown = {figure.name for figure, text in zip(FIGURES, figures(bare), strict=True) if text == "–"}
    assert unknown == {"ATE, RMS", "ATE, largest", "pose NEES / 3", "χ² / dof", "time"}
    assert all(
        text == "" for figure, text in zip(FIGURES, differences(bare, compared), strict=True) if figure.name in unknown
    )


def test_the_table_shows_of_the_choices_what_differs(two: tuple[Session, InlineEstimator]) -> None:
    rows = {name: (one, other) for name, one, other, _ in compare.rows_of(*pair(two[0]))}
    assert rows["estimator"] == ("sam", "direct")
    assert rows["made from"] == ("result 1 again", "whole log")
    assert "model" not in rows
    assert "100.0 mm" in compare.apart(*pair(two[0]))
    assert "no result" in "".join(compare.report(Results()))


def test_the_panel_offers_every_result_and_asks_by_number(page: Page, two: tuple[Session, InlineEstimator]) -> None:
    session, _ = two
    asked: list[object] = []
    panel = compare.ComparePanel(page.server.gui, asked.append)
    panel.refresh(session)
    widgets = page.server.gui._gui_input_handle_from_uuid.values()
    shown, over_it = (widget for widget in widgets if isinstance(widget, viser.GuiDropdownHandle))
    assert shown.value == "2: sam, normal-distance"
    assert over_it.value == "1: direct, normal-distance"
    assert over_it.options == (compare.NOTHING, *shown.options)
    assert not asked, "what the session changes must not be asked for again"
    assert [compare.number_of(label) for label in over_it.options] == [None, 1, 2]


def test_showing_the_compared_result_swaps_the_two(two: tuple[Session, InlineEstimator]) -> None:
    results = two[0].results
    shown, compared = pair(two[0])
    swapped = results.showing(compared)
    assert (swapped.shown, swapped.compared) == (compared, shown)
    assert results.comparing(shown).compared is None, "nothing is compared with itself"
    newer = replace(shown, processed=0)
    updated = swapped.updated(newer)
    assert updated.compared is newer
    assert newer in updated.all
    assert updated.shown is compared
