"""Maps as JSON there and back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bspline_slam.bspline import BSpline, uniform_knots
from bspline_slam.corners import corners_of, meeting
from bspline_slam.errors import LogError
from bspline_slam.export.map_json import map_from_json, map_to_json
from bspline_slam.spline_map import MapSpline, SplineMap
from core.test_corners import niche


def a_map(rng: np.random.Generator) -> tuple[SplineMap, dict[int, np.ndarray]]:
    splines = []
    for spline_id, degree, count in ((3, 3, 7), (8, 2, 4), (9, 1, 2)):
        curve = BSpline(degree, uniform_knots(0.5, 0.4, count, degree), rng.normal(0.0, 5.0, (count, 2)))
        splines.append(MapSpline(spline_id, curve, curve.domain, 12, 4, ("started",), left_out=count * 1e-7))
    root = rng.normal(0.0, 0.01, (14, 14))
    return SplineMap(tuple(splines)), {3: root @ root.T}


def test_a_map_comes_back_as_it_was(tmp_path: Path) -> None:
    spline_map, covariances = a_map(np.random.default_rng(1))
    map_to_json(spline_map, covariances, tmp_path / "map.json")
    again, covariances_again = map_from_json(tmp_path / "map.json")
    assert [spline.id for spline in again] == [3, 8, 9]
    for before, after in zip(spline_map, again, strict=True):
        assert after.curve.degree == before.curve.degree
        np.testing.assert_allclose(after.curve.knots, before.curve.knots, atol=1e-7)
        np.testing.assert_allclose(after.curve.control_points, before.curve.control_points, atol=1e-7)
        np.testing.assert_allclose(after.span, before.span, atol=1e-7)
        assert (after.born, after.observations, after.history) == (12, 4, ("started",))
        assert after.left_out == pytest.approx(before.left_out, rel=1e-8)
    assert covariances_again.keys() == {3}
    np.testing.assert_allclose(covariances_again[3], covariances[3], rtol=1e-8)


def test_corners_are_told_and_come_back(tmp_path: Path) -> None:
    joined = meeting(niche(1.2), [(3, 7)])
    map_to_json(joined, {}, tmp_path / "map.json")
    (row,) = json.loads((tmp_path / "map.json").read_text())["corners"]
    assert (row["before"], row["after"]) == (3, 7)
    assert row["turn"] == pytest.approx(1.2)
    (corner,) = corners_of(map_from_json(tmp_path / "map.json")[0])
    np.testing.assert_allclose(corner.point, row["point"], atol=1e-7)


def test_the_file_says_what_it_is(tmp_path: Path) -> None:
    map_to_json(SplineMap(), {}, tmp_path / "map.json")
    data = json.loads((tmp_path / "map.json").read_text())
    assert (data["format"], data["version"], data["units"]["length"]) == ("splinescope-map", 1, "m")
    assert data["splines"] == data["corners"] == []


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", "not a readable map"),
        ("[]", "not a map of splines"),
        ('{"format": "splinescope-map", "version": 9}', "version 9 of the map format, this program reads 1"),
        ('{"format": "splinescope-map", "version": 1}', "holds a spline that cannot be read"),
        ('{"format": "splinescope-map", "version": 1, "splines": [{"id": 1}]}', "cannot be read"),
    ],
)
def test_files_that_are_no_map(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "m.json").write_text(text)
    with pytest.raises(LogError, match=sentence):
        map_from_json(tmp_path / "m.json")


def test_a_map_from_before_tells_of_nothing_left_out(tmp_path: Path) -> None:
    map_to_json(*a_map(np.random.default_rng(2)), tmp_path / "map.json")
    data = json.loads((tmp_path / "map.json").read_text(encoding="utf-8"))
    for row in data["splines"]:
        del row["left_out"]
    (tmp_path / "old.json").write_text(json.dumps(data), encoding="utf-8")
    assert {spline.left_out for spline in map_from_json(tmp_path / "old.json")[0]} == {0.0}
