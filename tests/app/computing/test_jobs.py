"""What the estimator's process sends while it works."""

from __future__ import annotations

import pickle
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from app.estimator import Slam
from app.inline import stand_in
from app.logs import MemoryLog, corridor_log, file_of, write_carmen
from bspline_slam import se2
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.errors import SolverError
from bspline_slam.logs import open_log
from bspline_slam.slam import SlamConfig
from splinescope.computing import jobs
from splinescope.computing.jobs import Jobs
from splinescope.computing.messages import (
    ConsistencyFound,
    CovariancesFound,
    Failed,
    FindCovariances,
    Finished,
    Iterated,
    LogFile,
    MapChanged,
    Message,
    ProcessLog,
    Progress,
    QualityFound,
    SolveMap,
    StepsDone,
    Stopped,
)
from splinescope.computing.packed_result import SENT_BEFORE, PackedResult
from splinescope.computing.reporter import Reporter, seconds_left


def messages_of(*requests, cancelled=lambda: False) -> list[Message]:
    sent: list[Message] = []
    worker = Jobs(sent.append)
    for request in requests:
        worker.do(request, cancelled)
    return sent


def test_processing_sends_every_step_in_order_and_then_the_whole_map(log: MemoryLog) -> None:
    sent = messages_of(ProcessLog(1, file_of(log), SlamConfig()))
    steps = [step.scan for message in sent if isinstance(message, StepsDone) for step in message.steps]
    assert steps[: len(log)] == list(range(len(log)))
    assert any(isinstance(message, MapChanged) and len(message.snapshot.map) for message in sent)
    assert isinstance(sent[-1], Finished)
    assert sent[-1].snapshot is not None
    assert len(sent[-1].snapshot.poses) == len(log)


def test_a_cancelled_run_keeps_what_it_has(log: MemoryLog) -> None:
    countdown = count()
    sent = messages_of(ProcessLog(1, file_of(log), SlamConfig()), cancelled=lambda: next(countdown) > 12)
    assert isinstance(sent[-1], Stopped)
    assert sent[-1].snapshot is not None
    assert 0 < len(sent[-1].snapshot.poses) < len(log)


def test_solving_sends_iterations_with_falling_cost(log: MemoryLog) -> None:
    pipeline = Slam(log)
    list(pipeline.steps())
    sent = messages_of(SolveMap(1, file_of(log), PackedResult(pickle.dumps(pipeline.snapshot()), SlamConfig())))
    records = [message.record for message in sent if isinstance(message, Iterated)]
    assert records[0].index == 0
    assert isinstance(sent[-1], Finished)
    assert sent[-1].solution is not None
    assert sent[-1].solution.costs[-1] < sent[-1].solution.costs[0]
    assert sent[-1].kept is not None
    assert pickle.loads(sent[-1].kept).estimate is not None


def test_every_key_scan_gets_a_final_word_before_the_end(log: MemoryLog) -> None:
    sent = messages_of(ProcessLog(1, file_of(log), SlamConfig()))
    assert isinstance(sent[-1], Finished)
    assert sent[-1].kept is not None
    final = {step.scan: step for message in sent if isinstance(message, StepsDone) for step in message.steps}
    for step in pickle.loads(sent[-1].kept).steps:
        assert [a.spline for a in final[step.scan].associations] == [a.spline for a in step.associations]


def processed(log: MemoryLog) -> Finished:
    done = messages_of(ProcessLog(1, file_of(log), SlamConfig()))[-1]
    assert isinstance(done, Finished)
    return done


def covariances_of(kept: bytes | None, log: MemoryLog) -> FindCovariances:
    assert kept is not None
    return FindCovariances(2, file_of(log), PackedResult(kept, SlamConfig()))


def test_a_solved_map_is_tested_once_its_covariances_are_known(log: MemoryLog) -> None:
    done = processed(log)
    measured, found, tested, end = [
        m for m in messages_of(covariances_of(done.kept, log)) if not isinstance(m, Progress)
    ]
    assert isinstance(measured, QualityFound)
    assert isinstance(found, CovariancesFound)
    assert isinstance(tested, ConsistencyFound)
    assert isinstance(end, Finished)
    assert done.snapshot is not None
    assert found.splines.keys() == {spline.id for spline in done.snapshot.map}
    assert tested.tests is not None
    assert tested.tests.nees is not None


def test_the_trajectory_is_held_against_the_truth_where_there_is_one(
    log: MemoryLog, drive: MemoryLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert log.truth is not None
    done = processed(log)
    assert done.solution is not None
    assert done.solution.ate is not None
    assert done.snapshot is not None
    aligned = se2.compose(done.snapshot.poses[0], se2.between(log.truth[0], log.truth))
    assert 0 < done.solution.ate.rms < np.linalg.norm((done.snapshot.poses - aligned)[:, :2], axis=1).max()
    stand_in(monkeypatch, replace(drive, truth=None))
    without = processed(drive).solution
    assert without is not None
    assert without.ate is None


def test_a_map_that_was_never_solved_has_no_covariances(log: MemoryLog) -> None:
    pipeline = Slam(log)
    list(pipeline.steps())
    sent = messages_of(covariances_of(pickle.dumps(pipeline.snapshot()), log))
    assert [message.splines for message in sent if isinstance(message, CovariancesFound)] == [{}]


def test_cancelled_covariances_stop(log: MemoryLog) -> None:
    kept = processed(log).kept
    assert isinstance(messages_of(covariances_of(kept, log), cancelled=lambda: True)[-1], Stopped)


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
    last = messages_of(ProcessLog(7, file_of(log), SlamConfig()))[-1]
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


def test_a_snapshot_that_was_sent_before_need_not_be_sent_again(log: MemoryLog) -> None:
    asked = covariances_of(processed(log).kept, log)
    first = messages_of(asked)
    twice = messages_of(asked, replace(asked, job=3, result=replace(asked.result, kept=SENT_BEFORE)))[len(first) :]
    assert [type(message) for message in twice] == [type(message) for message in first]
    assert {message.job for message in twice} == {3}


def test_a_log_that_changes_on_disk_is_told_and_one_that_was_read_is_gone_on_with(tmp_path: Path) -> None:
    path, drive = tmp_path / "drive.log", corridor_log(np.random.default_rng(2), 24)
    known = file_of(open_log(write_carmen(drive, path)))
    sent: list[Message] = []
    worker = Jobs(sent.append)

    def said(file: LogFile) -> str:
        worker.do(ProcessLog(1, file, SlamConfig()), lambda: True)
        last = sent[-1]
        return last.sentence if isinstance(last, Failed) else type(last).__name__

    text = path.read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    for changed in ("".join(lines[:9]), text + lines[-1], "".join(lines[::-1])):  # cut off, appended to, replaced
        path.write_text(changed, encoding="utf-8")
        assert said(known) == f"drive.log: {jobs.CHANGED}"
        assert said(file_of(open_log(path))) == "Stopped", "opened again it is read anew"
    path.unlink()
    assert said(known) == "drive.log: no such file or folder"
    path.write_text(text, encoding="utf-8")
    assert said(known) == "Stopped"
    path.unlink()
    assert said(known) == "Stopped", "what was read is held"
