"""The pictures of the side bar: data come to lie where the axes say, and every text is escaped."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from splinescope.palette import BLUE, LineStyle
from splinescope.pictures import drawing
from splinescope.pictures.drawing import Axes
from splinescope.typeset import THIN


@pytest.mark.parametrize("extent", [(10.0, 0.0), (0.0, 10.0), (3.0, 2.0), (0.0, 0.0)])
def test_axes_to_scale_hold_all_points_and_stretch_nothing(extent: tuple[float, float]) -> None:
    points = np.array([[1.0, -2.0], np.add((1.0, -2.0), extent)])
    axes = Axes.to_scale(points, tallest=200.0, margin=16.0)
    placed = axes.at(points)
    left, top, right, bottom = axes.box
    assert (placed >= (left + 15.9, top + 15.9)).all()
    assert (placed <= (right - 15.9, bottom - 15.9)).all()
    assert bottom <= 201.0
    across, up = np.abs(axes.at(np.array([[0.0, 0.0], [1.0, 1.0]]))[1] - axes.at(np.zeros((1, 2)))[0])
    assert across == pytest.approx(axes.scale)
    assert up == pytest.approx(across, rel=0.02)


def test_up_is_up() -> None:
    axes = Axes((0.0, 0.0), (1.0, 1.0), (0.0, 0.0, 100.0, 50.0))
    assert axes.at(np.array([[0.0, 1.0]])).tolist() == [[0.0, 0.0]]
    assert axes.at(np.array([[1.0, 0.0]])).tolist() == [[100.0, 50.0]]


@pytest.mark.parametrize("scale", [3.0, 47.0, 900.0])
def test_the_scale_bar_is_as_long_as_it_says(scale: float) -> None:
    axes = Axes((0.0, 0.0), (drawing.WIDTH / scale, 1.0), (0.0, 0.0, drawing.WIDTH, 100.0))
    bar = drawing.scale_bar(axes)
    pixels = float(bar.split("v4h")[1].split("v")[0])
    metres = float(bar.split(f"{THIN}m</text>")[0].rsplit(">", 1)[1])
    assert pixels == pytest.approx(metres * scale, abs=0.06)
    assert 0.1 * drawing.WIDTH < pixels <= 0.3 * drawing.WIDTH


def test_an_ellipse_holds_86_percent() -> None:
    rng = np.random.default_rng(1)
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    rim = drawing.ellipse(np.zeros(2), covariance, 1.0) * (1.0, -1.0)
    squares = np.einsum("ni,ij,nj->n", rim, np.linalg.inv(covariance), rim)
    assert squares == pytest.approx(4.0)
    drawn = rng.multivariate_normal(np.zeros(2), covariance, 4000)
    inside = np.einsum("ni,ij,nj->n", drawn, np.linalg.inv(covariance), drawn) <= 4.0
    assert inside.mean() == pytest.approx(0.865, abs=0.02)


def test_a_picture_is_well_formed_whatever_its_words() -> None:
    parts = [
        drawing.words('<script>"&', 0.0, 0.0),
        drawing.legend([("a < b", BLUE, LineStyle.DASHED)], 10.0),
        drawing.dots(np.zeros((3, 2)), BLUE, hollow=True),
        drawing.labels(["1", "2"], np.ones((2, 2)), np.zeros((1, 2))),
    ]
    root = ElementTree.fromstring(drawing.picture(parts, 50.0, 'it says "<x>"'))
    assert root.get("aria-label") == 'it says "<x>"'
    assert len(root.findall(".//circle")) == 3
    assert [text.text for text in root.findall("text")] == ['<script>"&', "a < b", "1", "2"]


def test_labels_keep_apart() -> None:
    points = np.stack([np.linspace(0.0, 100.0, 41), np.zeros(41)], -1)
    kept = drawing.apart(points, 12.0)
    assert kept[0] == 0
    assert np.diff(points[kept, 0]).min() >= 12.0
