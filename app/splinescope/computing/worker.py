"""The estimator's process: started when first needed, told what to do, listened to, replaced when it dies."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, Protocol, runtime_checkable

from bspline_slam.backends.threads import single_thread
from bspline_slam.measuring import Picked
from bspline_slam.slam import SlamConfig
from splinescope.computing.edit_messages import EditRequest
from splinescope.computing.messages import (
    Failed,
    FindCovariances,
    LogFile,
    MeasureMap,
    Message,
    ProcessLog,
    Request,
    SolveMap,
)
from splinescope.computing.packed_result import SENT_BEFORE, PackedResult

NICENESS = 5
"""The estimator gives way to the page when both want the same core."""


class Worker:
    """Hands requests to a process of its own and gives every message it sends to `post` (from another thread).

    Jobs are numbered from 1 in the order of asking and done in that order, by the class `Jobs` of the module `jobs`.
    """

    def __init__(
        self, post: Callable[[Message], None], jobs: str = "splinescope.computing.jobs", niceness: int = NICENESS
    ) -> None:
        self._post, self._niceness = post, niceness
        self._jobs = jobs
        self._context = multiprocessing.get_context("spawn")
        self._cancelled = self._context.Value("q", 0, lock=False)
        self._job = 0
        self._sent: PackedResult | None = None
        self._process: BaseProcess | None = None
        self._requests: Any = None

    def start(self) -> None:
        """Start the process if it does not run, so that it is ready when asked."""
        if self._process is not None and self._process.is_alive():
            return
        inbox, outbox = self._context.Pipe(duplex=False)
        self._requests, self._sent = self._context.Queue(), None
        self._requests.cancel_join_thread()  # what a process that is gone has not read must not hold this one up
        process = self._process = self._context.Process(
            target=serve,
            args=(self._requests, outbox, self._cancelled, self._jobs, self._niceness),
            name=self._jobs,
            daemon=True,
        )
        process.start()
        outbox.close()
        threading.Thread(target=self._listen, args=(inbox, process), daemon=True).start()

    @property
    def process_id(self) -> int | None:
        """Number of the process in the system; None before it was first needed."""
        return self._process.pid if self._process is not None else None

    def process(self, log: LogFile, config: SlamConfig) -> int:
        """Ask for the whole pipeline over a log; returns the job's number. The process forgets what it got before."""
        self._sent = None
        return self._ask(ProcessLog(self._job + 1, log, config))

    def solve(self, log: LogFile, result: PackedResult) -> int:
        """Ask for the map of a result to be solved again; returns the job's number."""
        return self._ask(SolveMap(self._job + 1, log, result))

    def covariances(self, log: LogFile, result: PackedResult) -> int:
        """Ask how good the map of a result is; returns the job's number."""
        return self._ask(FindCovariances(self._job + 1, log, result))

    def measure(self, result: PackedResult, first: Picked, second: Picked) -> int:
        """Ask how far two things of the map of a result are apart; returns the job's number."""
        return self._ask(MeasureMap(self._job + 1, result, first, second))

    def cancel(self) -> None:
        """Stop every job asked for so far."""
        self._cancelled.value = self._job

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.join(5)

    def _ask(self, request: Request | EditRequest) -> int:
        self.start()
        self._job = request.job
        if isinstance(request, SolveMap | FindCovariances | MeasureMap):
            request = replace(request, result=self._shortened(request.result))
        self._requests.put(request)
        return request.job

    def _shortened(self, result: PackedResult) -> PackedResult:
        """A snapshot is large: one that the process got with the request before is not sent again."""
        before, self._sent = self._sent, result
        if before is None:
            return result
        kept = SENT_BEFORE if result.kept is before.kept else result.kept
        return replace(result, kept=kept, amended=None if result.amended is before.amended else result.amended)

    def _listen(self, inbox: Connection, process: BaseProcess) -> None:
        try:
            while True:
                self._post(inbox.recv())
        except (EOFError, OSError):
            process.join(5)
        if process is self._process:
            self._post(Failed(self._job, obituary(process.exitcode)))


def obituary(exit_code: int | None) -> str:
    """Why a process ended, for a person."""
    if exit_code is not None and exit_code < 0:
        name = signal.Signals(-exit_code).name
        reason = "the system stopped it, most likely for lack of memory" if name == "SIGKILL" else f"signal {name}"
    else:
        reason = f"exit code {exit_code}"
    return f"The estimator ended unexpectedly ({reason}). What it had sent before stands."


def serve(requests: Any, outbox: Connection, cancelled: Any, jobs_module: str, niceness: int) -> None:
    """The process: do requests for ever. It ends with the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(niceness)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    jobs = import_module(jobs_module).Jobs(outbox.send)  # slow to import: the estimator and its solvers
    backlog = Backlog(requests, jobs, cancelled)
    with single_thread():
        while True:
            request = backlog.next()
            jobs.do(request, backlog.asked_by(request))


@runtime_checkable
class Interruptible(Protocol):
    """One who does requests and can do some of them in the middle of another."""

    def meanwhile(self, request: Any, cancelled: Callable[[], bool]) -> bool:
        """Do a request, if it is one that need not wait; whether it is."""
        ...


class Backlog:
    """State: the requests that wait. Whenever a job asks whether it was cancelled, those that need not wait for its end
    are done first."""

    def __init__(self, requests: Any, jobs: Any, cancelled: Any) -> None:
        self._requests, self._jobs, self._cancelled = requests, jobs, cancelled
        self._waiting: deque[Any] = deque()

    def next(self) -> Any:
        """The request that is to be done next; waits for it."""
        return self._waiting.popleft() if self._waiting else self._requests.get()

    def asked_by(self, request: Any) -> Callable[[], bool]:
        """Tells the job of a request whether it was cancelled."""

        def cancelled() -> bool:
            while isinstance(self._jobs, Interruptible) and not self._requests.empty():
                other = self._requests.get()
                if not self._jobs.meanwhile(other, lambda job=other.job: self._cancelled.value >= job):
                    self._waiting.append(other)
            return self._cancelled.value >= request.job

        return cancelled


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(0)
