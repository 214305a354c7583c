"""Lost scans in words, and the way to them."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinescope.command_line.run import summary_text
from splinescope.lost_scans import MOST_RUNS, listed, lost_in_words, next_lost


@pytest.mark.parametrize(
    ("scans", "said"),
    [([4], "4"), ([4, 5, 6], "4–6"), ([1, 3, 4, 9], "1, 3–4, 9"), ([1200, 1201], "1,200–1,201")],
)
def test_neighbours_are_one_stretch(scans: list[int], said: str) -> None:
    assert listed(scans) == said


def test_a_long_list_says_how_much_is_left_out() -> None:
    assert listed(range(0, 2 * (MOST_RUNS + 3), 2)).endswith("and 3 more stretches")


def test_words_tell_the_count_and_what_was_done_instead() -> None:
    assert lost_in_words([], True).startswith("No scan was lost")
    assert lost_in_words([7], True).startswith("1 scan was lost")
    assert "odometry was trusted" in lost_in_words([7, 8], True)
    assert "odometry" not in lost_in_words([7, 8], False)


def test_the_end_of_a_run_tells_of_lost_scans_only_where_there_are_some() -> None:
    counts = {"scans": 9, "key_scans": 3, "splines": 2, "control_points": 12, "loop_closures": {"accepted": 0}}
    told = {"counts": counts, "log": {"odometry": True}, "seconds_total": 1.0, "peak_memory_mb": 9.0}
    told |= {"odometry_unfit_scans": [], "open_scans": []}
    assert "lost" not in summary_text(told | {"lost_scans": []}, Path("out"))
    assert "2 scans were lost" in summary_text(told | {"lost_scans": [4, 5]}, Path("out"))


def test_the_way_leads_from_stretch_to_stretch_in_a_circle() -> None:
    lost = [3, 4, 5, 9, 20, 21]
    assert [next_lost(lost, cursor) for cursor in (0, 3, 4, 9, 15, 20, 21, 30)] == [3, 9, 9, 20, 20, 3, 3, 3]
    assert next_lost([], 5) is None
    assert next_lost([4, 5], 4) == 4
