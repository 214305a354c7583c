"""Bytes of maps and grids are those that one can count."""

from __future__ import annotations

import numpy as np

from bspline_slam.lab.map_size import CELL, FREE, OCCUPIED, UNKNOWN, MapSize, occupancy
from bspline_slam.spline_map import SplineMap
from core.lab.walls import CORNERS, beams, room


def test_bytes_are_four_for_each_number() -> None:
    size = MapSize.of(room())
    assert size.raw == 4 * 4 * (2 * 7 + 11) and size.control_points == 28 and size.splines == 4
    assert size.packed < size.raw and size.grid_packed is None


def test_the_grid_covers_the_map() -> None:
    width, height = np.ptp(CORNERS, axis=0) / CELL
    assert abs(MapSize.of(room()).grid_raw / (width * height) - 1) < 0.03


def test_beams_draw_free_space_and_walls() -> None:
    grid = occupancy(room(), beams(0.0))
    assert set(np.unique(grid)) == {FREE, UNKNOWN, OCCUPIED}
    row, column = (int((at - low) / CELL) for at, low in ((0.5, CORNERS[:, 1].min()), (3.5, CORNERS[:, 0].min())))
    assert np.all(grid[row - 2 : row + 3, column - 2 : column + 3] == FREE)
    assert np.mean(grid[:, -2:] == OCCUPIED) > 0.2  # the wall ahead
    packed = MapSize.of(room(), beams(0.0)).grid_packed
    assert packed is not None and packed < grid.size


def test_an_empty_map_takes_nothing() -> None:
    size = MapSize.of(SplineMap())
    assert (size.splines, size.raw, size.grid_raw, size.metres) == (0, 0, 0, 0)
