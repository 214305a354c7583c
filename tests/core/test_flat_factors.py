"""Flat spline factors are the same factors."""

import numpy as np
import pytest

from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import SplineFactor


def factors(count: int, seed: int) -> list[SplineFactor]:
    """Factors of many sizes; every third one is a gauge."""
    rng = np.random.default_rng(seed)
    out = []
    for k in range(count):
        rows, points = rng.integers(1, 6), rng.integers(1, 5)
        readings, constant = (0, 0.0) if k % 3 == 0 else (int(rows) + k, float(k % 2))
        A, b = rng.normal(size=(rows, 2 * points)), rng.normal(size=rows)
        out.append(SplineFactor(int(rng.integers(7)), int(rng.integers(20)), A, b, readings, constant))
    return out


def assert_same(some: object, others: list[SplineFactor]) -> None:
    assert isinstance(some, FlatFactors)
    assert len(some) == len(others)
    for one, other in zip(some, others, strict=True):
        assert (one.pose, one.first, one.readings, one.constant) == (
            *(other.pose, other.first, other.readings, other.constant),
        )
        np.testing.assert_array_equal(one.A, other.A)
        np.testing.assert_array_equal(one.b, other.b)


@pytest.mark.parametrize("count", [0, 1, 12])
def test_flattened_they_read_as_before(count: int) -> None:
    given = factors(count, 1)
    flat = FlatFactors.of(given)
    assert_same(flat, given)
    assert_same(FlatFactors.of(flat[2:9]), given[2:9])
    for k in range(-count, count):
        np.testing.assert_array_equal(flat[k].A, given[k].A)


def test_joined_they_follow_each_other() -> None:
    parts = [factors(count, seed) for seed, count in enumerate((5, 0, 3))]
    assert_same(FlatFactors.joined([FlatFactors.of(part) for part in parts]), [one for part in parts for one in part])


def test_chosen_they_are_the_same_in_their_order() -> None:
    given = factors(12, 4)
    which = np.random.default_rng(5).random(12) < 0.5
    chosen = FlatFactors.of(given).chosen(which)
    wanted = [one for one, kept in zip(given, which, strict=True) if kept]
    assert_same(chosen, wanted)
    assert_same(FlatFactors.joined([chosen, FlatFactors.of(given)]), [*wanted, *given])


def test_what_is_flat_is_left_alone() -> None:
    flat = FlatFactors.of(factors(3, 2))
    assert FlatFactors.of(flat) is flat


def test_gauges_measure_nothing_and_sums_as_many_as_their_readings() -> None:
    given = factors(12, 3)
    wanted = [0 if f.readings == 0 else f.readings if f.constant > 0 else len(f.b) for f in given]
    assert FlatFactors.of(given).measured.tolist() == wanted


def test_compact_they_hold_no_more_than_is_read() -> None:
    given = factors(30, 4)
    flat = FlatFactors.of(given)
    assert flat.compact() is flat
    few = flat.chosen(np.arange(30) % 5 == 1)
    assert_same(few.compact(), given[1::5])
    assert len(few.compact().A) == sum(factor.A.size for factor in given[1::5])
    assert len(few.compact().b) == sum(factor.b.size for factor in given[1::5])
