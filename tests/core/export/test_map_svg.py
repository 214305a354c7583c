"""The drawing of a map: to scale, complete, and exact."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.bspline import BSpline, clamped_knots, uniform_knots
from bspline_slam.export.map_svg import bezier_pieces, map_to_svg
from bspline_slam.spline_map import MapSpline, SplineMap

SVG = "{http://www.w3.org/2000/svg}"


def a_map() -> SplineMap:
    wall = BSpline(3, uniform_knots(0.0, 1.0, 8), np.column_stack([np.arange(8.0), np.full(8, 2.0)]))
    corner = BSpline(1, clamped_knots(3, 1), np.array([[-3.0, 0.0], [-3.0, 4.0], [0.0, 4.0]]))
    return SplineMap((MapSpline(4, wall, wall.domain, born=0), MapSpline(11, corner, (0.25, 0.75), born=0)))


def drawn(tmp_path: Path, trajectory: np.ndarray | None = None, title: str = "Map") -> ElementTree.Element:
    map_to_svg(a_map(), tmp_path / "map.svg", trajectory=trajectory, title=title)
    return ElementTree.parse(tmp_path / "map.svg").getroot()


@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.integers(0, 5), st.booleans())
def test_pieces_are_the_curve_itself_up_to_degree_three(seed: int, degree: int, more: int, clamped: bool) -> None:
    rng = np.random.default_rng(seed)
    count = degree + 1 + more
    knots = clamped_knots(count, degree) if clamped else uniform_knots(0.0, 1 / (more + 1), count, degree)
    curve = BSpline(degree, knots, rng.normal(size=(count, 2)))
    a, b = np.sort(rng.uniform(*curve.domain, 2))
    pieces = bezier_pieces(curve, (float(a), float(b)))
    breaks = np.unique([a, *(knot for knot in knots if a < knot < b), b])
    u = np.linspace(0.0, 1.0, 7)
    bernstein = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3], -1)
    for piece, low, high in zip(pieces, breaks[:-1], breaks[1:], strict=True):
        np.testing.assert_allclose(bernstein @ piece, curve(low + u * (high - low)), atol=1e-9)


def test_everything_lies_inside_the_drawing_in_metres(tmp_path: Path) -> None:
    root = drawn(tmp_path, trajectory=np.array([[0.0, 0.0, 0.0], [6.0, -5.0, 0.0]]))
    x, y, width, height = map(float, root.attrib["viewBox"].split())
    assert x < -3.0
    assert x + width > 6.0
    assert -(y + height) < -5.0
    assert -y > 4.0
    np.testing.assert_allclose(float(root.attrib["width"]) / width, float(root.attrib["height"]) / height, rtol=2e-3)


def test_each_spline_is_a_path_with_its_id_from_end_to_end_of_its_span(tmp_path: Path) -> None:
    paths = {path.attrib.get("id"): path.attrib["d"] for path in drawn(tmp_path).iter(SVG + "path")}
    numbers = [float(word) for word in re.findall(r"-?\d+\.\d+", paths["spline-11"])]
    np.testing.assert_allclose(numbers[:2], [-3.0, 2.0])
    np.testing.assert_allclose(numbers[-2:], [-1.5, 4.0])
    assert "spline-4" in paths


def test_a_scale_bar_says_its_length(tmp_path: Path) -> None:
    root = drawn(tmp_path)
    label = next(text.text for text in root.iter(SVG + "text"))
    bar = next(path.attrib["d"] for path in root.iter(SVG + "path") if path.attrib.get("class") == "bar")
    drawn_length = re.search(r"h([\d.]+)", bar)
    assert drawn_length is not None
    assert label == f"{float(drawn_length.group(1)):g} m"


def test_a_title_is_text_whatever_it_holds(tmp_path: Path) -> None:
    title = next(drawn(tmp_path, title="<script>&").iter(SVG + "title"))
    assert title.text == "<script>&"


def test_a_standing_robot_is_a_dot_and_an_empty_map_still_a_drawing(tmp_path: Path) -> None:
    map_to_svg(SplineMap(), tmp_path / "empty.svg", trajectory=np.zeros((5, 3)))
    root = ElementTree.parse(tmp_path / "empty.svg").getroot()
    assert len(list(root.iter(SVG + "circle"))) == 1
