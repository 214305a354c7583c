"""The clock of the timeline."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from splinescope.playback import LONGEST_WAIT, SPEEDS, Playback, play_axis

AXIS = play_axis(np.arange(100) * 0.1)


def test_play_keeps_time_however_rarely_it_is_asked() -> None:
    once = Playback(AXIS, playing=True, speed=2.0).advanced(3.0)
    often = Playback(AXIS, playing=True, speed=2.0)
    for now in np.linspace(0.0, 3.0, 301):
        often = often.advanced(float(now))
    assert once.cursor == often.cursor == 60


def test_play_stops_at_the_end_and_starts_again_from_the_beginning() -> None:
    over = Playback(AXIS, playing=True).advanced(1000.0).advanced(1001.0)
    assert (over.cursor, over.playing, over.at_end) == (99, False, True)
    again = over.play(1001.0)
    assert (again.cursor, again.playing) == (0, True)


@given(st.lists(st.integers(-300, 300), max_size=20))
def test_seeking_and_stepping_stay_inside_the_log(moves: list[int]) -> None:
    playback = Playback(AXIS)
    for move in moves:
        before = playback.cursor
        playback = playback.step(move, 0.0)
        assert playback.cursor == min(max(before + move, 0), 99)
        assert playback.seek(move, 0.0).cursor == min(max(move, 0), 99)


def test_stepping_pauses_and_seeking_does_not() -> None:
    playing = Playback(AXIS, playing=True)
    assert not playing.step(1, 0.0).playing
    assert playing.seek(50, 0.0).playing


def test_speed_changes_keep_the_place() -> None:
    playback = Playback(AXIS, playing=True, speed=1.0).advanced(2.0)
    faster = playback.faster(1, 2.0)
    assert faster.cursor == playback.cursor
    assert faster.speed == 2.0
    assert faster.advanced(3.0).cursor == playback.cursor + 20
    assert playback.with_speed(1e9, 2.0).speed == SPEEDS[-1]
    assert playback.with_speed(0.0, 2.0).speed == SPEEDS[0]


def test_long_pauses_of_the_recording_are_not_waited_for() -> None:
    axis = play_axis(np.array([5.0, 6.0, 3606.0, 3607.0]))
    assert axis.tolist() == [0.0, 1.0, 1.0 + LONGEST_WAIT, 2.0 + LONGEST_WAIT]


def test_an_empty_log_and_a_single_scan_stand_still() -> None:
    for axis in (np.zeros(0), np.zeros(1)):
        playback = Playback(axis).play(0.0).advanced(5.0).step(1, 5.0)
        assert (playback.cursor, playback.playing) == (0, False)
