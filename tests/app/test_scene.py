"""The scene: every layer draws, only changes are sent, and a building stays within what a slow browser can draw."""

from dataclasses import replace

import numpy as np
import pytest

from app import views
from app.chromium import until
from bspline_slam.association import Verdict
from splinescope.browser.page import Page
from splinescope.browser.values import Viewport
from splinescope.grades import RESIDUALS
from splinescope.palette import DARK, LIGHT, VERDICT_STYLES, theme
from splinescope.scene import Scene, bounds_of
from splinescope.scene.detail import Detail
from splinescope.scene.legend import legend
from splinescope.scene.map_layers import compared, loop_closures, splines
from splinescope.scene.scan_layers import robot, ties
from splinescope.scene.scene import DRAWINGS, Frame, graded_by, hint
from splinescope.view import Colouring, GhostView, Layer, Selection, View

CLOSE = Viewport(2.5, 2.0, 0.01, 900, 700)
BUDGET = 8000  # line segments: about a third of a second a frame without a GPU


@pytest.fixture(scope="module")
def view() -> View:
    return views.office(np.random.default_rng(1))


@pytest.fixture(scope="module")
def building() -> View:
    return views.large(np.random.default_rng(1))


def counts(view: View, viewport: Viewport) -> dict[str, int]:
    frame = Frame(view, theme(view.dark), Detail.of(viewport))
    return {drawing.name: len(drawing.draw(frame)) for drawing in DRAWINGS}


def test_every_layer_draws_something(view: View) -> None:
    assert view.map is not None
    lines = np.stack([view.map.estimate[:5, :2], view.map.estimate[:5, :2] + 0.5], axis=1)
    ghost = GhostView(view.map.map, view.map.estimate, view.map.estimate[:9, :2], ((0.0, 0.0),), lines, ((1.0, 1.0),))
    chosen = replace(view, selection=Selection("control point", 3, 2), compared=view.map, measured=np.eye(2))
    chosen = replace(chosen, ghost=ghost)
    drawn = counts(replace(chosen, colouring=Colouring.RESIDUAL), CLOSE)
    assert {name for name, count in drawn.items() if count == 0} == set()
    assert {drawing.layer for drawing in DRAWINGS} - {None} == set(Layer) - {Layer.GRID}


def test_an_empty_view_draws_nothing() -> None:
    assert sum(counts(View(layers=views.ALL_LAYERS), CLOSE).values()) == 0
    assert bounds_of(View()) is None


def test_a_building_from_afar_keeps_to_the_budget(building: View) -> None:
    whole = bounds_of(building)
    assert whole is not None
    scale = (whole[3] - whole[1]) / 600
    viewport = Viewport((whole[0] + whole[2]) / 2, (whole[1] + whole[3]) / 2, scale, 900, 700)
    assert sum(counts(building, viewport).values()) < BUDGET


def test_a_building_from_near_keeps_to_the_budget(building: View) -> None:
    assert sum(counts(building, Viewport(2.5, 2.0, 0.012, 900, 700)).values()) < BUDGET + 4000


def test_each_decision_shows_its_own_hue_and_glyph(view: View) -> None:
    assert view.scan is not None
    shapes = {}
    for association in view.scan.associations:
        alone = replace(view.scan, associations=(replace(association, by="rule"),))
        drawn = ties(alone, view.map, DARK, Detail.of(CLOSE))
        shapes[association.verdict] = (len(drawn), tuple(drawn.colours[0].tolist()))
    assert len(set(shapes.values())) == len(shapes) > 1


def test_a_decision_by_hand_is_marked(view: View) -> None:
    assert view.scan is not None
    first = view.scan.associations[0]
    drawn = [
        len(ties(replace(view.scan, associations=(replace(first, by=by),)), view.map, DARK, Detail.of(CLOSE)))
        for by in ("rule", "hand")
    ]
    assert drawn[1] > drawn[0]


@pytest.mark.parametrize("scale", [0.002, 0.02, 0.2])
def test_the_robot_never_gets_small(view: View, scale: float) -> None:
    assert view.scan is not None
    drawn = robot(view.scan, DARK, Detail.of(Viewport(0, 0, scale, 900, 700)))
    assert np.ptp(drawn.segments.reshape(-1, 2), axis=0).max() >= 14 * scale


def test_a_lost_scan_is_told_by_hue_and_by_a_sign(view: View) -> None:
    assert view.scan is not None
    known, lost = (robot(replace(view.scan, lost=lost), DARK, Detail.of(CLOSE)) for lost in (False, True))
    assert len(lost) > len(known)
    assert not np.array_equal(lost.colours[0], known.colours[0])


def test_a_rejected_loop_is_broken_in_the_middle(view: View) -> None:
    assert view.map is not None
    only = replace(view.map, loop_closures=view.map.loop_closures[:1])
    pair = [replace(view.map.loop_closures[0], accepted=accepted) for accepted in (True, False)]
    whole, broken = (loop_closures(replace(only, loop_closures=(c,)), DARK, Detail.of(CLOSE)) for c in pair)
    assert [len(whole), len(broken)] == [1, 2]
    assert not np.array_equal(whole.colours[0], broken.colours[0])


def test_two_results_have_one_hue_each_and_only_one_of_them_is_whole(view: View) -> None:
    both = replace(view, compared=view.map)
    assert both.map is not None
    frame = Frame(both, theme(both.dark, both.comparing), Detail.of(CLOSE))
    whole, over_it = splines(both.map, frame.theme, frame.detail), compared(both.map, frame.theme, frame.detail)
    assert len(np.unique(whole.colours, axis=0)) == len(np.unique(over_it.colours, axis=0)) == 1
    assert not np.array_equal(whole.colours[0], over_it.colours[0])
    lengths = [np.linalg.norm(np.diff(s.segments, axis=1), axis=-1).sum() for s in (whole, over_it)]
    assert lengths[1] < 0.9 * lengths[0]


@pytest.mark.parametrize("colouring", [c for c in Colouring if c is not Colouring.SPLINE])
def test_while_grades_are_in_colour_curves_are_drawn_once(view: View, colouring: Colouring) -> None:
    coloured = replace(view, colouring=colouring)
    assert coloured.map is not None and graded_by(coloured) is not None
    frame = Frame(coloured, theme(view.dark, grading=True), Detail.of(CLOSE))
    drawn = {d.name: d.draw(frame).segments for d in DRAWINGS if d.layer is Layer.SPLINES}
    dotted = drawn.pop("splines")
    lengths = [np.linalg.norm(np.diff(s, axis=1), axis=-1).sum() for s in (*drawn.values(), dotted)]
    whole = sum(spline.length for spline in coloured.map.map)
    assert 0.85 * whole < sum(lengths[:-1]) <= sum(lengths) <= whole * 1.001


def test_the_legend_tells_the_grades_while_they_are_shown() -> None:
    titles = [section["title"] for section in legend(theme(True, grading=True), RESIDUALS)]
    assert titles[0] == "Residuals along curves, RMS"
    assert titles[1:] == [section["title"] for section in legend(DARK)]


def test_a_result_compared_on_a_layer_that_is_off_changes_no_hue(view: View) -> None:
    assert not replace(view, compared=view.map, layers=view.layers - {Layer.COMPARED}).comparing
    assert not view.comparing


def test_the_legend_explains_every_verdict() -> None:
    for ground in (DARK, LIGHT):
        text = str(legend(ground))
        assert all(VERDICT_STYLES[verdict].label in text for verdict in Verdict)


def test_what_is_too_small_to_be_drawn_is_said(view: View) -> None:
    far, near = Detail.of(Viewport(0, 0, 0.1, 900, 700)), Detail.of(CLOSE)
    assert hint(view, far) == "Zoom in to see control points, ellipses, breakpoints, map control points, map ellipses"
    assert hint(replace(view, scan=None), far) == "Zoom in to see map control points, map ellipses"
    assert hint(view, near) == ""
    assert hint(replace(view, layers=frozenset({Layer.SPLINES})), far) == ""


def test_bounds_hold_the_map_and_the_path(view: View) -> None:
    bounds = bounds_of(view)
    assert view.map is not None
    assert bounds is not None
    for points in (view.map.estimate[:, :2], *(s.curve.control_points for s in view.map.map)):
        assert (points >= bounds[:2]).all()
        assert (points <= bounds[2:]).all()


class Ledger:
    """Counts the bytes of line work that the server sends."""

    def __init__(self, page: Page) -> None:
        self.bytes = 0
        send = page.server._websock_server.queue_message

        def counted(message: object) -> None:
            for value in getattr(message, "updates", {}).values():
                self.bytes += getattr(value, "nbytes", 0)
            send(message)  # pyright: ignore[reportArgumentType]

        page.server._websock_server.queue_message = counted

    def spent(self) -> int:
        """Bytes since the last time it was asked."""
        spent, self.bytes = self.bytes, 0
        return spent


def test_only_what_changed_is_sent(page: Page, view: View) -> None:
    scene, ledger = Scene(page), Ledger(page)
    scene.draw(view)
    whole = ledger.spent()
    scene.draw(view)
    assert ledger.spent() == 0
    assert view.map is not None
    assert view.scan is not None
    moved = replace(view.scan, pose=view.scan.pose + 0.02)
    scene.draw(replace(view, scan=moved))
    step = ledger.spent()
    assert 0 < step < whole
    grown = replace(view.map, estimate=view.map.estimate[:-5])
    scene.draw(replace(view, scan=moved, map=grown))
    assert 0 < ledger.spent() < step
    scene.draw(replace(view, scan=moved, selection=Selection("spline", 3)))
    assert 0 < ledger.spent() < whole
    scene.draw(replace(view, scan=moved, selection=Selection("spline", 3), layers=view.layers - {Layer.SPLINES}))
    assert ledger.spent() == 0


def test_a_step_through_a_building_sends_kilobytes(page: Page, building: View) -> None:
    scene, ledger = Scene(page), Ledger(page)
    scene.draw(building)
    whole = ledger.spent()
    assert building.scan is not None
    scene.draw(replace(building, scan=replace(building.scan, pose=building.scan.pose + 0.01)))
    assert ledger.spent() < min(40_000, whole)


def test_the_browser_shows_what_is_drawn(page: Page, view: View, open_window) -> None:
    scene = Scene(page)
    bounds = bounds_of(view)
    assert bounds is not None
    page.fit(bounds)
    window = open_window(page.url)
    until(lambda: page.viewport is not None, "the page to say what it sees")
    for dark in (True, False):
        shown = replace(view, dark=dark)
        until(lambda shown=shown: scene.draw(shown) or not scene.stale, "the drawing to fit the view")
        expected = scene.segment_counts["splines"]
        until(lambda n=expected: (window.node("/splinescope/splines") or {}).get("segments") == n, "the splines")
        window.page.wait_for_timeout(500)
        window.screenshot(f"scene-{'dark' if dark else 'light'}")
    scene.draw(replace(view, layers=view.layers - {Layer.SPLINES}))
    until(lambda: not (window.node("/splinescope/splines") or {}).get("visible"), "the splines to go")
    assert (window.node("/splinescope/segments") or {})["visible"]
