"""The progress line of the terminal."""

from __future__ import annotations

import io

from splinescope.command_line.progress import ProgressLine, clock_time, describe


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_sees_one_line_per_stage_rewritten_in_place() -> None:
    now, stream = [0.0], Terminal()
    line = ProgressLine(stream, lambda: now[0])
    for percent in range(101):
        now[0] += 0.02
        line("Reading", percent / 100)
    line("Solving", 0.0)
    line.end()
    first, second, rest = stream.getvalue().split("\n")
    assert (second, rest) == ("\r\033[KSolving  0 %", "")
    assert first.endswith("Reading  done in 0:02")
    assert 10 < first.count("\r") < 50


def test_a_file_gets_a_line_each_tenth() -> None:
    stream = io.StringIO()
    line = ProgressLine(stream, lambda: 0.0)
    for percent in range(101):
        line("Reading", percent / 100)
    line.end()
    assert stream.getvalue().splitlines() == [*(f"Reading  {10 * i} %" for i in range(10)), "Reading  done in 0:00"]


def test_time_left_is_said_once_it_can_be_known() -> None:
    assert describe("Reading", 0.25, 30.0) == "Reading  25 %  1:30 left"
    assert describe("Reading", 0.0, 30.0) == "Reading  0 %"


def test_times_read_like_a_clock() -> None:
    assert [clock_time(s) for s in (7.2, 750, 3723)] == ["0:07", "12:30", "1:02:03"]
