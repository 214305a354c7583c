"""The estimator's jobs done at once in this process, their messages kept until asked for."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

from app import estimator
from bspline_slam.measuring import Picked
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamConfig
from splinescope.browser.preferences import Preferences
from splinescope.commands import LogOpened, OpenLog
from splinescope.computing import jobs
from splinescope.computing.messages import FindCovariances, LogFile, MeasureMap, Message, ProcessLog, Request, SolveMap
from splinescope.computing.packed_result import PackedResult
from splinescope.session import Session


class InlineEstimator:
    """Stands where the worker stands; nothing runs beside the test."""

    def __init__(self) -> None:
        self.messages: list[Message] = []
        self.cancelled = 0
        self.asked: list[Request] = []
        self._jobs = jobs.Jobs(self.messages.append)

    def process(self, log: LogFile, config: SlamConfig) -> int:
        return self._do(lambda job: ProcessLog(job, log, config))

    def solve(self, log: LogFile, result: PackedResult) -> int:
        return self._do(lambda job: SolveMap(job, log, result))

    def covariances(self, log: LogFile, result: PackedResult) -> int:
        return self._do(lambda job: FindCovariances(job, log, result))

    def measure(self, result: PackedResult, first: Picked, second: Picked) -> int:
        return self._do(lambda job: MeasureMap(job, result, first, second))

    def cancel(self) -> None:
        self.cancelled = len(self.asked)

    def _do(self, request: Callable[[int], Request]) -> int:
        self.asked.append(request(len(self.asked) + 1))
        self._jobs.do(self.asked[-1], lambda: False)
        return len(self.asked)


def stand_in(monkeypatch, log: ScanLog) -> None:
    """Let the jobs use the stand-in estimator, and find `log` wherever they look."""
    monkeypatch.setattr(jobs, "slam", SimpleNamespace(Slam=estimator.Slam))
    monkeypatch.setattr(jobs, "estimates", SimpleNamespace(adjust=estimator.adjust, marginals=estimator.marginals))
    monkeypatch.setattr(jobs, "scan_consistency", estimator.scan_consistency)
    monkeypatch.setattr(jobs, "open_log", lambda path: log)


def session_with(log: ScanLog) -> tuple[Session, InlineEstimator]:
    """A session that has just opened the log; what the estimator says about it still waits in `messages`."""
    inline = InlineEstimator()
    opened: list[OpenLog] = []
    session = Session(inline, opened.append, Preferences(), clock=lambda: 0.0)
    session.apply(OpenLog(log.path))
    session.apply(LogOpened(opened[0], log))
    return session, inline


def deliver(session: Session, inline: InlineEstimator) -> None:
    """Give the session all that the estimator has said, also in answer to that."""
    while inline.messages:
        session.receive(inline.messages.pop(0))
