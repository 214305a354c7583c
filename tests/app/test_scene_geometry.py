"""The line work of the scene: near what it stands for, and no more of it than needed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app import views
from bspline_slam.bspline import BSpline, clamped_knots
from splinescope.browser.values import Viewport
from splinescope.palette import Glyph, LineStyle, theme
from splinescope.scene import ghost_layers
from splinescope.scene.curves import sampled
from splinescope.scene.detail import OVERVIEW, Detail
from splinescope.scene.ellipses import ellipses
from splinescope.scene.paths import simplified
from splinescope.scene.strokes import broken, dashed, glyphs
from splinescope.view import GhostView

seeds = st.integers(0, 2**32 - 1)
WARNING = np.array([213, 94, 0], dtype=np.uint8)
EVERYWHERE = (-np.inf, -np.inf, np.inf, np.inf)


@given(seed=seeds, style=st.sampled_from(LineStyle))
def test_broken_segments_lie_on_what_was_broken_and_keep_the_share_of_ink(seed: int, style: LineStyle) -> None:
    rng = np.random.default_rng(seed)
    segments = rng.uniform(-5.0, 5.0, (40, 2, 2))
    parts = broken(segments, style, pixel=0.01)
    assert distance_to(segments, parts.reshape(-1, 2)).max() < 1e-9
    ink = sum(style.pattern[::2]) / sum(style.pattern) if style.pattern else 1.0
    before, after = (np.linalg.norm(np.diff(each, axis=1), axis=-1).sum() for each in (segments, parts))
    assert after == pytest.approx(ink * before, rel=0.01)


def distance_to(segments: np.ndarray, points: np.ndarray) -> np.ndarray:
    """From each point to the nearest of the segments."""
    step = segments[:, 1] - segments[:, 0]
    off = points[:, None] - segments[None, :, 0]
    square = np.maximum((step**2).sum(-1), 1e-18)
    share = np.clip((off * step).sum(-1) / square, 0.0, 1.0)
    return np.linalg.norm(off - share[..., None] * step, axis=-1).min(axis=1)


@given(seed=seeds, degree=st.integers(1, 5), pixel=st.sampled_from([0.3, 0.03, 0.003]))
def test_samples_stay_within_a_pixel_of_the_curve(seed: int, degree: int, pixel: float) -> None:
    rng = np.random.default_rng(seed)
    steps = rng.normal(0.3, 0.2, (degree + 4, 2))
    curve = BSpline(degree, clamped_knots(len(steps), degree), np.cumsum(steps, axis=0))
    segments, owner = sampled([curve], [curve.domain], Detail(pixel, EVERYWHERE))
    points = curve(np.linspace(*curve.domain, 300))
    assert distance_to(segments, points).max() < pixel
    assert np.allclose(segments[0, 0], points[0])
    assert np.allclose(segments[-1, 1], points[-1])
    assert np.array_equal(segments[1:, 0], segments[:-1, 1]) or np.allclose(segments[1:, 0], segments[:-1, 1])
    assert set(owner) == {0}


def test_samples_keep_to_the_span_and_name_their_curve() -> None:
    splines = views.floor_map().splines
    spans = [(s.span[0] + 0.3, s.span[1] - 0.2) for s in splines]
    segments, owner = sampled([s.curve for s in splines], spans, OVERVIEW)
    for i, spline in enumerate(splines):
        mine = segments[owner == i]
        assert np.allclose([mine[0, 0], mine[-1, 1]], spline.curve(np.array(spans[i])))


def test_a_curve_outside_of_the_window_costs_little() -> None:
    curve = views.spline_along(np.array([[0.0, 0.0], [1.0, 0.3], [2.0, -0.5], [3.0, 1.0]]))
    near, _ = sampled([curve], [curve.domain], Detail(0.001, (-1.0, -1.0, 4.0, 4.0)))
    far, _ = sampled([curve], [curve.domain], Detail(0.001, (50.0, 50.0, 60.0, 60.0)))
    assert len(far) <= len(curve.control_points) - curve.degree < len(near)


@given(seed=seeds, tolerance=st.floats(0.01, 1.0))
def test_a_simplified_path_stays_near_the_path(seed: int, tolerance: float) -> None:
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.normal(0.0, 0.2, (80, 2)), axis=0)
    short = simplified(path, tolerance)
    segments = np.stack([short[:-1], short[1:]], axis=1)
    assert np.array_equal(short[[0, -1]], path[[0, -1]])
    assert distance_to(segments, path).max() <= tolerance + 1e-9


def test_a_robot_at_rest_costs_two_points() -> None:
    rest = np.tile([[3.0, 4.0]], (500, 1)) + np.random.default_rng(0).normal(0.0, 1e-4, (500, 2))
    assert len(simplified(rest, 0.05)) <= 3


@given(style=st.sampled_from([s for s in LineStyle if s.pattern]), length=st.floats(0.5, 30.0))
def test_dashes_cover_the_share_of_the_line_that_their_pattern_says(style: LineStyle, length: float) -> None:
    bend = np.array([[0.0, 0.0], [0.6 * length, 0.0], [0.6 * length, 0.4 * length]])
    segments = dashed(bend, style, pixel=0.01)
    drawn = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum()
    period = 0.01 * sum(style.pattern)
    assert drawn / length == pytest.approx(sum(style.pattern[::2]) / sum(style.pattern), abs=period / length)
    assert distance_to(np.stack([bend[:-1], bend[1:]], axis=1), segments.reshape(-1, 2)).max() < 1e-9


def test_a_solid_line_has_no_gaps() -> None:
    line = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 2.0]])
    assert np.array_equal(dashed(line, LineStyle.SOLID, 0.01), np.stack([line[:-1], line[1:]], axis=1))


@pytest.mark.parametrize("glyph", list(Glyph))
def test_glyphs_have_the_size_they_are_given(glyph: Glyph) -> None:
    drawn = glyphs(glyph, np.array([[5.0, -2.0]]), WARNING[None], radius=0.3)
    reach = np.abs(drawn.segments.reshape(-1, 2) - [5.0, -2.0]).max()
    assert 0.2 < reach < 0.4
    assert len(drawn.colours) == len(drawn)


@given(seed=seeds)
def test_an_ellipse_holds_the_points_at_two_sigma(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(0.0, 0.05, (2, 2)) + 0.02 * np.eye(2)
    covariance = root @ root.T + 1e-6 * np.eye(2)
    drawn = ellipses(np.array([[1.0, 2.0]]), covariance[None], WARNING[None], 0.001, WARNING)
    off = drawn.segments[:, 0] - [1.0, 2.0]
    mahalanobis = np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off)
    assert np.allclose(mahalanobis, 4.0, rtol=1e-6) or len(drawn) == 1


@pytest.mark.parametrize(
    ("covariance", "segments", "extent"),
    [
        (np.zeros((2, 2)), 2, 0.003),
        (np.diag([0.04, 0.0]), 1, 0.4),
        (np.diag([0.04, -0.01]), 5, None),
        (np.full((2, 2), np.nan), 5, None),
        (np.array([[1.0, 0.5], [-0.5, 1.0]]), 5, None),
    ],
    ids=["zero is a point", "rank one is a line", "negative warns", "not a number warns", "unsymmetric warns"],
)
def test_degenerate_covariances_are_told_apart(covariance: np.ndarray, segments: int, extent: float | None) -> None:
    drawn = ellipses(np.zeros((1, 2)), covariance[None], np.zeros((1, 3), np.uint8), 0.001, WARNING)
    assert len(drawn) == segments
    if extent is None:
        assert (drawn.colours == WARNING).all()
    else:
        assert np.abs(drawn.segments).max() == pytest.approx(extent)


def test_detail_stays_the_same_under_small_moves_and_follows_large_ones() -> None:
    here = Viewport(3.0, 4.0, 0.0101, 900, 700)
    nudged = Viewport(3.05, 4.05, 0.0102, 900, 700)
    away = Viewport(23.0, 4.0, 0.0101, 900, 700)
    closer = Viewport(3.0, 4.0, 0.004, 900, 700)
    assert Detail.of(here) == Detail.of(nudged)
    assert Detail.of(here) != Detail.of(away)
    assert Detail.of(here).pixel > Detail.of(closer).pixel


@given(x=st.floats(-500, 500), y=st.floats(-500, 500), scale=st.floats(0.0005, 0.5))
def test_the_window_of_a_detail_holds_all_that_is_seen(x: float, y: float, scale: float) -> None:
    viewport = Viewport(x, y, scale, 900, 700)
    x_min, y_min, x_max, y_max = viewport.bounds
    corners = np.array([[x_min, y_min], [x_max, y_max]])
    detail = Detail.of(viewport)
    assert detail.inside(corners).all()
    assert 0.8 < detail.pixel / scale < 1.25


def test_of_moves_from_one_place_the_longest_is_drawn_and_none_that_would_be_a_dot() -> None:
    detail, start = Detail(0.01, EVERYWHERE), np.array([[1.005, 1.005], [1.006, 1.006], [3.0, 3.0], [5.0, 5.0]])
    step = np.array([[0.2, 0.0], [0.3, 0.0], [0.0, 0.4], [0.0, 0.001]])
    lines = np.stack([start, start + step], axis=1)
    drawn = ghost_layers.moves(GhostView(moves=lines), theme(dark=True), detail)
    assert np.array_equal(drawn.segments, lines[[1, 2]])
    assert len(ghost_layers.moves(GhostView(), theme(dark=True), detail)) == 0


def test_a_pin_touches_the_place_that_it_holds_and_stands_above_it() -> None:
    detail, place = Detail(0.01, EVERYWHERE), (3.0, 4.0)
    points = ghost_layers.by_hand(GhostView(pins=(place,)), theme(dark=True), detail).segments.reshape(-1, 2)
    assert np.linalg.norm(points - place, axis=1).min() < 1e-9
    assert points[:, 1].min() >= place[1] - 1e-9
    assert len(ghost_layers.by_hand(GhostView(), theme(dark=True), detail)) == 0
