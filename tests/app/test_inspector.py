"""What the inspector and the decision table say, and that they never say it unescaped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app import views
from bspline_slam.association import Association, Candidate, Verdict
from bspline_slam.corners import meeting
from bspline_slam.slam import SlamStep
from core.test_corners import niche
from splinescope import table
from splinescope.inspector import decision, describe, ellipse_axes, residual
from splinescope.panels.decisions import decisions
from splinescope.panels.inspector import parts
from splinescope.view import Selection, View


@pytest.fixture(scope="module")
def shown() -> View:
    return views.office(np.random.default_rng(5))


def step_of(shown: View) -> SlamStep:
    scan = shown.scan
    assert scan is not None
    return SlamStep(scan.scan.index, scan.pose, scan.pose, True, False, 0.8, (), scan.associations)


def test_a_segment_tells_its_beams_its_fit_and_its_verdict(shown: View) -> None:
    assert shown.scan is not None
    found = describe(Selection("segment", 1), shown.scan, shown.map, {})
    segment = shown.scan.segments[1].segment
    rows = dict(found.rows)
    assert rows["beams"].startswith(f"{segment.beams[0]} … {segment.beams[-1]}")
    assert rows["begins at"] == segment.start.value
    assert len(found.decisions) == 1
    assert "by hand" in found.decisions[0]


def test_a_segment_of_another_scan_says_that_it_is_not_in_the_graph(shown: View) -> None:
    assert shown.scan is not None
    other = replace(shown.scan, key=False, associations=())
    assert "not a key scan" in describe(Selection("segment", 0), other, shown.map, {}).sentence


def test_a_spline_tells_who_saw_it_and_how_well_it_is_known(shown: View) -> None:
    step = step_of(shown)
    spline = next(a.spline for a in step.associations if a.spline is not None)
    rows = dict(describe(Selection("spline", spline), shown.scan, shown.map, {step.scan: step}).rows)
    assert rows["last seen at scan"] == str(step.scan)
    assert rows["least certain point, 2σ"].endswith("mm")


def test_a_spline_tells_what_it_meets_in_a_corner(shown: View) -> None:
    assert shown.map is not None
    world = replace(shown.map, map=meeting(niche(), [(3, 7)]))
    rows = [dict(describe(Selection("spline", one.id), shown.scan, world, {}).rows) for one in world.map]
    assert rows[0]["corner at its end"] == "with spline 7" and "corner at its start" not in rows[0]
    assert rows[1]["corner at its start"] == "with spline 3" and "corner at its end" not in rows[1]


def test_a_control_point_tells_its_ellipse_or_that_it_is_not_known_yet(shown: View) -> None:
    assert shown.map is not None
    known = dict(describe(Selection("control point", 0, 2), shown.scan, shown.map, {}).rows)
    assert "×" in known["2σ ellipse, half axes"]
    bare = replace(shown.map, covariances={})
    assert (
        dict(describe(Selection("control point", 0, 2), shown.scan, bare, {}).rows)["2σ ellipse"] == "not computed yet"
    )


def test_a_key_pose_tells_its_match_and_its_loop_closures(shown: View) -> None:
    assert shown.map is not None
    scan = shown.map.loop_closures[0].earlier
    step = replace(step_of(shown), scan=scan, lost=True)
    found = describe(Selection("key pose", scan), shown.scan, shown.map, {scan: step})
    assert "lost" in dict(found.rows)["score of the match"]
    assert any("Loop closure" in sentence and "seen again" in sentence for sentence in found.history)


@pytest.mark.parametrize("kind", ["segment", "spline", "control point", "key pose"])
def test_what_is_gone_says_so(shown: View, kind: str) -> None:
    assert "not in the map any more" in describe(Selection(kind, 9999, 9999), shown.scan, shown.map, {}).sentence


def test_the_axes_of_an_ellipse_are_twice_the_standard_deviations() -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert ellipse_axes(turn @ np.diag([0.01, 0.0004]) @ turn.T) == pytest.approx((0.2, 0.04))
    assert ellipse_axes(np.diag([1.0, -1e-12])) == pytest.approx((2.0, 0.0))


def test_the_residual_of_a_perfect_fit_is_nothing(shown: View) -> None:
    assert shown.scan is not None
    fit = shown.scan.segments[0]
    assert fit.curve is not None
    points = fit.curve(np.linspace(*fit.curve.domain, len(fit.segment.points)))
    perfect = replace(fit, segment=replace(fit.segment, points=points))
    assert residual(perfect) < 1e-9
    assert np.isnan(residual(replace(fit, curve=None)))


def test_a_decision_is_a_sentence_with_its_runner_up() -> None:
    candidates = (Candidate(4, 0.02, 0.9), Candidate(7, 0.13, 0.4))
    said = decision(Association(3, 1, 10, 40, Verdict.MATCHED, 4, 0.02, 0.1, candidates))
    assert said == "Beams 10–40: matched, spline 4, 20.0 mm of 100.0 mm allowed; runner-up spline 7 at 130.0 mm."
    assert decision(Association(3, 1, 10, 40, Verdict.NEW, 9, float("nan"), 0.1)) == "Beams 10–40: new, spline 9."


def test_the_table_has_a_row_for_every_decision_and_marks_the_selected_segment(shown: View) -> None:
    assert shown.scan is not None
    text = "".join(decisions(shown.scan, 1))
    assert text.count("<tr") == 1 + len(shown.scan.associations)
    assert text.count('class="lead on"') == 1
    for association in shown.scan.associations:
        assert association.verdict.value in text


def test_an_empty_table_says_why(shown: View) -> None:
    assert shown.scan is not None
    assert "No scan" in decisions(None, None)[0]
    assert "not a key scan" in decisions(replace(shown.scan, key=False), None)[0]
    assert "no segment" in decisions(replace(shown.scan, associations=()), None)[0]


def test_nothing_from_a_log_reaches_the_page_as_markup(shown: View) -> None:
    evil = "<img src=x onerror=alert(1)>"
    assert shown.map is not None
    splines = tuple(replace(spline, history=(evil,)) for spline in shown.map.map)
    world = replace(shown.map, map=replace(shown.map.map, splines=splines))
    texts = [
        *parts(describe(Selection("spline", 0), shown.scan, world, {})),
        table.paragraph(evil),
        table.bullets([evil]),
        table.pairs([(evil, evil)]),
        table.table([evil], [[evil]]),
        table.heading(evil),
    ]
    assert all("<img" not in text for text in texts)
    assert "&lt;img" in "".join(texts)
