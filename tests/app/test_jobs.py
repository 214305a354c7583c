"""What the estimator's process sends while it works."""

from __future__ import annotations

import pickle
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from app.estimator import Slam
from app.inline import stand_in
from app.logs import MemoryLog, corridor_log
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.errors import SolverError
from splinescope import jobs
from splinescope.jobs import Jobs
from splinescope.messages import (
    ConsistencyFound,
    CovariancesFound,
    Failed,
    FindCovariances,
    Finished,
    Iterated,
    MapChanged,
    Message,
    ProcessLog,
    Progress,
    SolveMap,
    StepsDone,
    Stopped,
)
from splinescope.reporter import Reporter, seconds_left


@pytest.fixture(scope="module")
def drive() -> MemoryLog:
    return corridor_log(np.random.default_rng(1))


@pytest.fixture
def log(drive: MemoryLog, monkeypatch: pytest.MonkeyPatch) -> MemoryLog:
    stand_in(monkeypatch, drive)
    return drive


def messages_of(*requests, cancelled=lambda: False) -> list[Message]:
    sent: list[Message] = []
    worker = Jobs(sent.append)
    for request in requests:
        worker.do(request, cancelled)
    return sent


def test_processing_sends_every_step_in_order_and_then_the_whole_map(log: MemoryLog) -> None:
    sent = messages_of(ProcessLog(1, Path("x")))
    steps = [step.scan for message in sent if isinstance(message, StepsDone) for step in message.steps]
    assert steps[: len(log)] == list(range(len(log)))
    assert any(isinstance(message, MapChanged) and len(message.snapshot.map) for message in sent)
    assert isinstance(sent[-1], Finished)
    assert sent[-1].snapshot is not None
    assert len(sent[-1].snapshot.poses) == len(log)


def test_a_cancelled_run_keeps_what_it_has(log: MemoryLog) -> None:
    countdown = count()
    sent = messages_of(ProcessLog(1, Path("x")), cancelled=lambda: next(countdown) > 12)
    assert isinstance(sent[-1], Stopped)
    assert sent[-1].snapshot is not None
    assert 0 < len(sent[-1].snapshot.poses) < len(log)


def test_solving_sends_iterations_with_falling_cost(log: MemoryLog) -> None:
    pipeline = Slam(log)
    list(pipeline.steps())
    sent = messages_of(SolveMap(1, Path("x"), pickle.dumps(pipeline.snapshot()), "direct"))
    records = [message.record for message in sent if isinstance(message, Iterated)]
    assert records[0].index == 0
    assert isinstance(sent[-1], Finished)
    assert sent[-1].solution is not None
    assert sent[-1].solution.costs[-1] < sent[-1].solution.costs[0]
    assert sent[-1].kept is not None
    assert pickle.loads(sent[-1].kept).estimate is not None


def test_every_key_scan_gets_a_final_word_before_the_end(log: MemoryLog) -> None:
    sent = messages_of(ProcessLog(1, Path("x")))
    assert isinstance(sent[-1], Finished)
    assert sent[-1].kept is not None
    final = {step.scan: step for message in sent if isinstance(message, StepsDone) for step in message.steps}
    for step in pickle.loads(sent[-1].kept).steps:
        assert [a.spline for a in final[step.scan].associations] == [a.spline for a in step.associations]


def test_covariances_come_for_every_spline_of_a_solved_map(log: MemoryLog) -> None:
    sent = messages_of(ProcessLog(1, Path("x")), FindCovariances(2, "direct"))
    found = next(message for message in sent if isinstance(message, CovariancesFound))
    finished = next(message for message in sent if isinstance(message, Finished))
    assert finished.snapshot is not None
    assert found.splines.keys() == {spline.id for spline in finished.snapshot.map}


def test_a_solved_map_is_tested_once_its_covariances_are_known(log: MemoryLog) -> None:
    sent = messages_of(ProcessLog(1, Path("x")), FindCovariances(2, "direct"))
    kinds = [type(message) for message in sent if not isinstance(message, Progress)]
    assert kinds[-3:] == [CovariancesFound, ConsistencyFound, Finished]
    tests = next(message.tests for message in sent if isinstance(message, ConsistencyFound))
    assert tests is not None
    assert tests.nees is not None


def test_covariances_of_no_map_are_none() -> None:
    found, done = [m for m in messages_of(FindCovariances(1, "direct")) if not isinstance(m, Progress)]
    assert isinstance(found, CovariancesFound)
    assert not found.splines
    assert isinstance(done, Finished)


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (SolverError("the graph has no prior"), "the graph has no prior"),
        (ZeroDivisionError("1/0"), "ZeroDivisionError"),
    ],
)
def test_what_goes_wrong_becomes_a_sentence(
    log: MemoryLog, monkeypatch: pytest.MonkeyPatch, error: Exception, sentence: str
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(jobs.slam, "Slam", fail)
    last = messages_of(ProcessLog(7, Path("x")))[-1]
    assert isinstance(last, Failed)
    assert last.job == 7
    assert sentence in last.sentence


def test_iterations_are_thinned_by_the_clock_but_never_the_first() -> None:
    sent: list[Message] = []
    now = iter(np.arange(0.0, 1000.0, 0.01))
    reporter = Reporter(1, sent.append, clock=lambda: float(next(now)))
    for index in range(100):
        record = IterationRecord(index, 1.0, 0.0, 0.0, 0.0, np.zeros((0, 3)), np.zeros((0, 2)))
        reporter.progress("Solving", index / 100, record)
    kept = [message.record.index for message in sent if isinstance(message, Iterated)]
    assert kept[0] == 0
    assert len(kept) <= 6


def test_time_left_is_told_only_when_it_is_more_than_a_guess() -> None:
    assert seconds_left(0.5, 0.5) is None
    assert seconds_left(10.0, 0.01) is None
    assert seconds_left(10.0, 0.25) == pytest.approx(30.0)
    assert seconds_left(10.0, 1.0) == 0.0
