"""The estimator's process, for real: work, cancel, failure, death."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from app.chromium import PATIENCE
from app.logs import corridor_log, file_of, write_carmen
from app.running import COMPILING
from bspline_slam.logs import open_log
from bspline_slam.slam import SlamConfig
from splinescope.computing.messages import (
    CovariancesFound,
    Failed,
    Finished,
    LogFile,
    Message,
    Progress,
    StepsDone,
    Stopped,
)
from splinescope.computing.packed_result import PackedResult
from splinescope.computing.worker import Worker, obituary

CONFIG = SlamConfig()

Until = Callable[[type[Message]], list[Message]]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> LogFile:
    made = corridor_log(np.random.default_rng(4), 60)
    return file_of(open_log(write_carmen(made, tmp_path_factory.mktemp("logs") / "corridor.log")))


@pytest.fixture(scope="module")
def running() -> Iterator[tuple[Worker, Until]]:
    inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
    worker = Worker(inbox.put)

    def until(kind: type[Message]) -> list[Message]:
        got: list[Message] = [inbox.get(timeout=COMPILING)]
        while not isinstance(got[-1], kind):
            got.append(inbox.get(timeout=COMPILING))
        return got

    yield worker, until
    worker.close()


def test_a_log_is_processed_solved_and_its_covariances_found(running: tuple[Worker, Until], log: LogFile) -> None:
    worker, until = running
    job = worker.process(log, CONFIG)
    messages = until(Finished)
    assert {message.job for message in messages} == {job}
    assert [s.scan for m in messages if isinstance(m, StepsDone) for s in m.steps][:60] == list(range(60))
    done = messages[-1]
    assert isinstance(done, Finished)
    assert done.snapshot is not None
    assert len(done.snapshot.map) > 0

    assert done.kept is not None
    worker.covariances(log, PackedResult(done.kept, CONFIG))
    found = next(message for message in until(Finished) if isinstance(message, CovariancesFound))
    assert set(found.splines) <= {spline.id for spline in done.snapshot.map}
    assert len(found.splines) > 0

    worker.solve(log, PackedResult(done.kept, CONFIG))
    solved = until(Finished)[-1]
    assert isinstance(solved, Finished)
    assert solved.snapshot is not None
    assert solved.solution is not None


def test_a_cancelled_job_stops_and_the_next_one_is_done(running: tuple[Worker, Until], log: LogFile) -> None:
    worker, until = running
    worker.process(log, CONFIG)
    worker.cancel()
    assert until(Stopped)[-1].job == worker.process(log, CONFIG) - 1
    assert until(Finished)


def test_a_file_that_is_no_log_is_a_sentence(running: tuple[Worker, Until], tmp_path: Path) -> None:
    worker, until = running
    worker.process(LogFile(tmp_path / "nowhere.log", ""), CONFIG)
    failed = until(Failed)[-1]
    assert isinstance(failed, Failed)
    assert "nowhere.log" in failed.sentence


def test_a_killed_process_is_a_sentence_and_is_replaced(running: tuple[Worker, Until], log: LogFile) -> None:
    worker, until = running
    job = worker.process(log, CONFIG)
    until(Progress)
    assert worker.process_id is not None
    os.kill(worker.process_id, signal.SIGKILL)
    failed = until(Failed)[-1]
    assert isinstance(failed, Failed)
    assert failed.job == job
    assert "lack of memory" in failed.sentence
    worker.process(log, CONFIG)
    assert until(Finished)


def test_an_obituary_names_the_reason() -> None:
    assert "SIGSEGV" in obituary(-signal.SIGSEGV)
    assert "exit code 3" in obituary(3)


ENDING = """
import os, signal
from pathlib import Path
from bspline_slam.slam import SlamConfig
from splinescope.computing.messages import LogFile
from splinescope.computing.packed_result import PackedResult
from splinescope.computing.worker import Worker

worker = Worker(lambda message: None)
worker.start()
os.kill(worker.process_id, signal.SIGSTOP)
worker.solve(LogFile(Path("a.log"), ""), PackedResult(bytes(10_000_000), SlamConfig(), (), None))
worker.close()
"""


def test_a_program_ends_although_the_estimator_did_not_read_all_that_it_was_sent() -> None:
    ended = subprocess.run([sys.executable, "-c", ENDING], timeout=PATIENCE, check=False)
    assert ended.returncode == 0
