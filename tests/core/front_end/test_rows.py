"""Poses that come one by one: the same as a list of them."""

from __future__ import annotations

import numpy as np
import pytest

from bspline_slam.front_end.rows import Rows


@pytest.mark.parametrize("start", [0, 1, 16, 40])
def test_rows_are_a_list_that_is_an_array_at_once(start: int) -> None:
    poses = np.random.default_rng(start).normal(size=(start + 50, 3))
    rows = Rows(poses[:start])
    for pose in poses[start:]:
        rows.append(pose)
    assert len(rows) == len(poses)
    np.testing.assert_array_equal(np.array(rows), poses)
    np.testing.assert_array_equal(rows[-7:], poses[-7:])
    np.testing.assert_array_equal(rows[-1], poses[-1])
    np.testing.assert_array_equal(np.stack(list(rows)), poses)


def test_what_was_read_does_not_change_with_what_comes_later() -> None:
    rows = Rows()
    rows.append(np.ones(3))
    last, whole = rows[-1], np.array(rows)
    last += 1.0
    whole += 1.0
    rows.append(np.zeros(3))
    np.testing.assert_array_equal(rows[0], np.ones(3))
