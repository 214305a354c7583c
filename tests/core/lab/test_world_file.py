"""World files: what each shape becomes, and a sentence for everything that is wrong with one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bspline_slam.errors import ConfigError
from bspline_slam.lab.world import World
from bspline_slam.lab.world_file import built_in_worlds, open_world, parse_world

DRIVE = {"way_points": [[0, 0], [1, 0], [2, 0], [3, 0]]}
CIRCLE = {"shape": "circle", "centre": [0, 0], "radius": 1}


def world(*shapes: dict[str, Any], laser: Any = None, drive: Any = None) -> World:
    """The world of these shapes, as if read from room.json."""
    content = {"laser": laser if laser is not None else {}, "drive": drive or DRIVE, "shapes": shapes}
    return parse_world(json.dumps(content), "room.json")


def ray(here: World, origin: tuple[float, float], angle: float) -> float:
    """The range in one direction (degrees)."""
    direction = np.array([[np.cos(np.radians(angle)), np.sin(np.radians(angle))]])
    return float(here.cast(np.array(origin, dtype=float), direction)[0])


def test_a_door_lets_rays_through_and_its_wall_has_two_faces() -> None:
    here = world({"shape": "wall", "ends": [[0, 0], [4, 0]], "thickness": 0.2, "doors": [[1.5, 1.0]]})
    assert ray(here, (0.5, 2), -90) == pytest.approx(1.9) and ray(here, (0.5, -2), 90) == pytest.approx(1.9)
    assert ray(here, (1.5, 2), -90) == np.inf
    assert ray(here, (1.5, 0), 0) == pytest.approx(0.5) and ray(here, (1.5, 0), 180) == pytest.approx(0.5)


def test_a_box_is_turned_about_its_centre() -> None:
    here = world({"shape": "box", "centre": [3, 1], "size": [2, 1], "turn": 90})
    assert ray(here, (0, 1), 0) == pytest.approx(2.5) and ray(here, (3, -3), 90) == pytest.approx(3.0)


def test_an_arc_runs_either_way_round() -> None:
    for start, end in ((0, 90), (90, 0)):
        here = world({"shape": "arc", "centre": [0, 0], "radius": 2, "start": start, "end": end})
        assert ray(here, (0, 0), 45) == pytest.approx(2.0) and ray(here, (0, 0), -45) == np.inf


def test_a_curved_wall_is_closed_at_its_ends() -> None:
    curved = {"shape": "curved_wall", "centre": [0, 0], "radius": 2, "start": 0, "end": 90, "thickness": 0.2}
    here = world(curved)
    assert ray(here, (0, 0), 45) == pytest.approx(1.9) and ray(here, (3, 3), -135) == pytest.approx(18**0.5 - 2.1)
    assert ray(here, (2, -1), 90) == pytest.approx(1.0) and ray(here, (-1, 2), 0) == pytest.approx(1.0)


def test_a_closed_spline_surrounds_its_middle_without_a_corner() -> None:
    corners = [[2, 0], [1, 2], [-1, 2], [-2, 0], [-1, -2], [1, -2]]
    here = world({"shape": "spline", "control_points": corners, "closed": True})
    (curve,) = here.splines
    ends = np.array(curve.domain)
    for derivative in (0, 1, 2):
        first, last = curve(ends, derivative)
        assert np.allclose(first, last)
    assert all(np.isfinite(ray(here, (0, 0), angle)) for angle in range(0, 360, 7))


def test_the_laser_and_the_drive_are_taken_over_in_radians() -> None:
    laser = {"field_of_view": 270, "resolution": 0.5, "range_min": 0.1, "range_max": 8, "pose": [0.2, 0.1, 90]}
    here = world(CIRCLE, laser=laser, drive={**DRIVE, "speed": 0.3, "turn_rate": 45, "scan_period": 2})
    bearings = here.laser.bearings
    assert len(bearings) == 540 and bearings[0] == pytest.approx(-0.75 * np.pi)
    assert np.allclose(np.diff(bearings), np.radians(0.5))
    assert here.laser.pose_robot_sensor == pytest.approx([0.2, 0.1, np.pi / 2])
    assert (here.drive.speed, here.drive.turn_rate, here.drive.scan_period) == pytest.approx((0.3, np.pi / 4, 2.0))


def test_worlds_open_by_name_and_by_path(tmp_path: Path) -> None:
    assert built_in_worlds() == ("corridor", "office", "three_splines")
    assert len(open_world("three_splines").splines) == 3
    own = tmp_path / "own.json"
    own.write_text(json.dumps({"laser": {}, "drive": DRIVE, "shapes": [CIRCLE]}))
    assert open_world(own).name == open_world(str(own)).name == "own"


@pytest.mark.parametrize(
    ("shape", "sentence"),
    [
        ({"shape": "cube"}, 'shape 1: "shape" must be one of polyline, wall, box, arc, curved_wall, circle, spline'),
        ({"centre": [0, 0]}, 'shape 1: "shape" must be one of'),
        ({"shape": "circle", "name": "table", "radius": 1}, "shape 1 (table): the key centre is missing"),
        ({"shape": "circle", "centre": [0, 0], "size": 1, "radius": 1}, "unknown key size; known are centre, radius"),
        ({"shape": "circle", "centre": [0, 0], "radius": 0}, "its radius must be positive, got 0"),
        ({"shape": "circle", "centre": [0, 0], "radius": "1"}, 'radius must be a number, got "1"'),
        ({"shape": "circle", "centre": [0], "radius": 1}, "centre must be a pair of numbers, got [0]"),
        ({"shape": "box", "centre": [0, 0], "size": [1, 0]}, "its size must be positive, got 1 by 0"),
        ({"shape": "polyline", "points": [[0, 0]]}, "it needs at least 2 points, got 1"),
        ({"shape": "polyline", "points": [[0, 0], [1]]}, "points must be a list of pairs of numbers"),
        ({"shape": "wall", "ends": [[0, 0], [3, 0]], "doors": [[1, 1], [1.5, 1]]}, "its doors overlap or lie beyond"),
        ({"shape": "wall", "ends": [[0, 0], [3, 0]], "doors": [[3, 1]]}, "beyond its length of 3 m"),
        ({"shape": "wall", "ends": [[1, 1], [1, 1]]}, "its two ends must lie apart"),
        ({"shape": "arc", "centre": [0, 0], "radius": 1, "start": 9, "end": 9}, "starts and ends at the same angle"),
        ({"shape": "spline", "control_points": [[0, 0], [1, 0], [2, 0]]}, "it needs at least 4 points, got 3"),
    ],
)
def test_a_wrong_shape_is_named_with_its_place(shape: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ConfigError) as error:
        world(shape)
    assert str(error.value).startswith("room.json: shape 1") and sentence in str(error.value)


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        ({"laser": {"resolution": 200}}, "laser: resolution 200° and field of view 180° do not go together"),
        ({"laser": {"range_max": 0.01}}, "laser: range_max 0.01 must exceed range_min 0.05"),
        ({"laser": [1]}, "laser: expected an object with keys, got list"),
        ({"drive": {**DRIVE, "speed": 0}}, "drive: speed must be positive, got 0"),
        ({"drive": {"way_points": [[0, 0], [1, 0]]}}, "drive: it needs at least 4 points, got 2"),
        ({"drive": {"way_points": [[1, 1]] * 4}}, "drive: its way points all lie on one place"),
    ],
)
def test_a_wrong_laser_or_drive_is_said(part: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ConfigError) as error:
        world(CIRCLE, **part)
    assert str(error.value) == f"room.json: {sentence}"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{\n  oops", "room.json:2: not valid JSON"),
        ("[]", "room.json: a world needs the keys laser, drive and shapes"),
        ('{"laser": {}, "drive": {}}', "room.json: a world needs the keys laser, drive and shapes"),
        ('{"laser": {}, "drive": {}, "shapes": []}', "room.json: shapes must be a list of at least one shape"),
    ],
)
def test_a_file_that_is_not_a_world_is_said(text: str, sentence: str) -> None:
    with pytest.raises(ConfigError) as error:
        parse_world(text, "room.json")
    assert sentence in str(error.value)


def test_a_file_that_is_not_text_is_said(tmp_path: Path) -> None:
    binary = tmp_path / "room.json"
    binary.write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(ConfigError, match=r"room\.json is not a text file"):
        open_world(binary)
