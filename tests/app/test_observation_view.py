"""The selected segment taken apart, for every segment of a key scan, and a sentence where that is impossible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.views import floor_map, map_view, scan_view
from bspline_slam.association import Verdict
from bspline_slam.observation_steps import ObservedRelation
from bspline_slam.relation import EndRelation, Relation
from bspline_slam.slam import SlamConfig
from splinescope.observation_view import ObservationStep, ObservationView, view_observation
from splinescope.palette import DARK, LIGHT
from splinescope.panels import observation as panel
from splinescope.pictures.observation import observation_picture
from splinescope.view import MapView, ScanView, Selection

CONFIG = SlamConfig()


@pytest.fixture
def scan() -> ScanView:
    return scan_view(floor_map(), np.array([2.3, 1.3, 1.2]), 12, np.random.default_rng(3))


@pytest.fixture
def world() -> MapView:
    return replace(map_view(np.random.default_rng(3)), map=floor_map())


def views(scan: ScanView, world: MapView | None) -> list[ObservationView]:
    found = [
        view_observation(scan, world, Selection("segment", fitted.segment.index), CONFIG) for fitted in scan.segments
    ]
    return [view for view in found if isinstance(view, ObservationView)]


def test_every_segment_of_a_key_scan_has_every_step(scan: ScanView, world: MapView) -> None:
    found = views(scan, world)
    assert len(found) == len(scan.segments) > 2
    for view in found:
        for step in ObservationStep:
            assert panel.explanation(view, step)
            for theme in (DARK, LIGHT):
                drawn = observation_picture(view, step, theme)
                assert drawn.startswith("<svg") or isinstance(view.relation, str)
                assert "nan" not in drawn
                assert "inf" not in drawn


def test_a_piece_is_held_against_the_spline_it_was_given_to(scan: ScanView, world: MapView) -> None:
    related = [view for view in views(scan, world) if isinstance(view.relation, ObservedRelation)]
    assert related
    for view in related:
        assert isinstance(view.relation, ObservedRelation)
        assert view.association is not None
        start = view.relation.decision.start
        row = panel.end_row("start", start, True, start, view.relation.decision.end)
        inwards = float(row[3].rstrip("°"))
        assert (inwards < 0) == (start.relation is EndRelation.BEYOND) or start.relation is EndRelation.COINCIDES
        text = "".join(panel.explanation(view, ObservationStep.RELATION))
        assert f"spline {view.association.spline}" in text
        assert f"Relation: {view.relation.decision.relation.value}" in text


def test_a_wall_seen_in_part_is_a_part(scan: ScanView, world: MapView) -> None:
    relations = {view.relation.decision.relation for view in views(scan, world) if not isinstance(view.relation, str)}
    assert Relation.PART in relations


def test_what_has_no_spline_says_why(scan: ScanView, world: MapView) -> None:
    for verdict, why in ((Verdict.GATED, "too far from every spline"), (Verdict.IGNORED, "was left out")):
        turned_away = tuple(replace(a, verdict=verdict, spline=None) for a in scan.associations)
        assert all(why in str(view.relation) for view in views(replace(scan, associations=turned_away), world))
    gone = views(scan, None)[0]
    assert "not in the map any more" in str(gone.relation)
    undecided = views(replace(scan, associations=()), world)[0]
    assert "Nothing was decided" in str(undecided.relation)


def test_pieces_of_a_segment_are_gone_through_in_a_circle(scan: ScanView, world: MapView) -> None:
    whole = next(a for a in scan.associations if a.verdict is Verdict.MATCHED)
    middle = (whole.first + whole.last) // 2
    cut = (replace(whole, last=middle + 2), replace(whole, first=middle + 3))
    two = replace(scan, associations=cut)
    seen = [view_observation(two, world, Selection("segment", whole.segment, sub), CONFIG) for sub in range(3)]
    assert [view.piece for view in seen if isinstance(view, ObservationView)] == [0, 1, 0]
    for view, association in zip(seen, (*cut, cut[0]), strict=True):
        assert isinstance(view, ObservationView)
        assert isinstance(view.relation, ObservedRelation)
        assert view.pieces == 2
        assert view.association is association
        assert len(view.relation.points) < len(view.steps.points)


@pytest.mark.parametrize(
    ("change", "selection", "said"),
    [
        ({}, None, "No segment is selected"),
        ({}, Selection("spline", 1), "No segment is selected"),
        ({}, Selection("segment", 99), "has no segment 99"),
        ({"key": False}, Selection("segment", 0), "not a key scan"),
        ({"segments": ()}, Selection("segment", 0), "has no segment: too few of its beams"),
    ],
)
def test_what_is_missing_is_said(
    scan: ScanView, world: MapView, change: dict, selection: Selection | None, said: str
) -> None:
    assert said in str(view_observation(replace(scan, **change), world, selection, CONFIG))


def test_beams_in_one_place_cannot_be_observed(scan: ScanView, world: MapView) -> None:
    first = scan.segments[0]
    heap = replace(first.segment, points=np.ones_like(first.segment.points))
    found = view_observation(
        replace(scan, segments=(replace(first, segment=heap),)), world, Selection("segment", 0), CONFIG
    )
    assert "cannot be observed: a curve needs at least two distinct points" in str(found)
    assert "No scan" in str(view_observation(None, None, None, CONFIG))


def test_steps_end_at_both_ends() -> None:
    first, last = ObservationStep.PARAMETERS, ObservationStep.RELATION
    assert first.moved(-1) is first
    assert last.moved(1) is last
    assert [step.number for step in ObservationStep] == [1, 2, 3, 4, 5]
    assert first.moved(4) is last


def test_the_spline_of_the_map_counts_only_where_scans_support_it(scan: ScanView, world: MapView) -> None:
    spline = world.map.splines[0]
    low, high = spline.curve.domain
    span = (low + 0.3, high - 0.5)
    shorter = replace(world, map=replace(world.map, splines=(replace(spline, span=span), *world.map.splines[1:])))
    related = [
        view.relation
        for view in views(replace(scan, associations=tuple(replace(a, spline=0) for a in scan.associations)), shorter)
        if not isinstance(view.relation, str)
    ]
    assert related
    assert all(np.ptp(relation.full_spline.domain) == pytest.approx(span[1] - span[0]) for relation in related)


def test_a_run_by_another_model_is_said_to_be_one(scan: ScanView, world: MapView) -> None:
    view = views(scan, world)[0]
    assert "This run observes by normal-distance" in "".join(panel.headline(view))
    assert "This run" not in "".join(panel.headline(replace(view, model="chord-length")))


def test_the_published_model_has_its_fixed_number_of_control_points(scan: ScanView, world: MapView) -> None:
    longest = max(scan.segments, key=lambda fitted: len(fitted.segment.beams)).segment
    config = replace(CONFIG, model="chord-length")
    view = view_observation(scan, world, Selection("segment", longest.index), config)
    assert isinstance(view, ObservationView)
    assert len(view.steps.curve.control_points) == config.chord_length.control_points
    assert "This run" not in "".join(panel.headline(view))
