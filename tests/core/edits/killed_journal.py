"""Processes that accept edits and are killed at random moments: `killed_journal.py JOURNAL ROUNDS`.

A program of its own, for it forks, and a test run has threads. Prints the rounds and the entries at their end.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from pathlib import Path

from bspline_slam.edits.edit import DropLoop
from bspline_slam.edits.history import Accept, Accepted
from bspline_slam.edits.journal import Journal, Origin, read_journal

ORIGIN = Origin("/logs/a.log", "abc", {"back_end": "direct"})


def accept_for_ever(path: Path, told: int) -> None:
    """Append, and tell of each action once it is accepted, until somebody kills it."""
    journal = Journal(path, ORIGIN)
    for number in range(len(journal.history.entries), 2**31):
        journal.append(Accept(f"number {number}", 0.0, (DropLoop(number, number + 1),)))
        os.write(told, number.to_bytes(4, "big"))


def one_round(path: Path, seconds: float) -> int:
    """The number of the last action that a process told of before it was killed, after so many seconds."""
    inbox, outbox = os.pipe()
    process = os.fork()
    if process == 0:
        os.close(inbox)
        accept_for_ever(path, outbox)
    os.close(outbox)
    first = os.read(inbox, 4)
    time.sleep(seconds)
    os.kill(process, signal.SIGKILL)
    assert os.WTERMSIG(os.waitpid(process, 0)[1]) == signal.SIGKILL
    with os.fdopen(inbox, "rb") as rest:
        told = first + rest.read()
    return int.from_bytes(told[-4:], "big")


def main(path: Path, rounds: int) -> None:
    """Kill, and look at what is left, again and again."""
    rng = random.Random(3)
    entries = 0
    for _ in range(rounds):
        accepted = one_round(path, rng.uniform(0.0, 0.01))
        history = read_journal(path).history
        entries = len(history.entries)
        assert entries in (accepted + 1, accepted + 2), (entries, accepted)
        names = [entry.action.name for entry in history.entries if isinstance(entry, Accepted)]
        assert names == [f"number {number}" for number in range(entries)]
    sys.stdout.write(f"{rounds} {entries}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
