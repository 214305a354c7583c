"""Both halves are done, each piece once."""

import numpy as np
import pytest

from bspline_slam.halves import LEAST, in_halves


@pytest.mark.parametrize("labour", [[], [3], [1, 1, 1], [LEAST], [LEAST, 0, 1], [0, 0, 2 * LEAST, LEAST, 5 * LEAST]])
def test_every_piece_is_worked_on_once(labour: list[int]) -> None:
    done = np.zeros(len(labour), dtype=np.int64)

    def work(first: int, last: int) -> None:
        done[first:last] += 1

    in_halves(work, np.cumsum([0, *labour]))
    assert (done == 1).all()


def test_large_labour_is_shared_about_evenly() -> None:
    parts = []
    in_halves(lambda first, last: parts.append(last - first), np.arange(0, 100 * LEAST, LEAST))
    assert len(parts) == 2
    assert abs(parts[0] - parts[1]) <= 1


def test_what_goes_wrong_in_either_half_is_told() -> None:
    def work(first: int, last: int) -> None:
        if first == 0:
            raise ValueError("no knots")

    with pytest.raises(ValueError, match="no knots"):
        in_halves(work, np.array([0, LEAST, 2 * LEAST]))
