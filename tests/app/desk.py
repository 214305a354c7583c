"""A session with a finished run of a sample log, and an editor that does its work in this process when it is told."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from app.logs import file_of
from bspline_slam.association import Association
from bspline_slam.edits.edit import (
    Edit,
)
from bspline_slam.logs import open_log
from bspline_slam.measuring import Picked
from bspline_slam.slam import SlamConfig
from splinescope import commands as ask
from splinescope.browser.preferences import Preferences
from splinescope.computing.edit_jobs import Jobs as EditJobs
from splinescope.computing.edit_messages import (
    EditRequest,
    FindPreview,
    HandOver,
    MakeEdits,
    MatchLoop,
    Prepare,
)
from splinescope.computing.messages import (
    LogFile,
    Message,
)
from splinescope.computing.packed_result import PackedResult
from splinescope.edits.editing import Editing
from splinescope.edits.journals import Journals
from splinescope.edits.subject import EditKind
from splinescope.pieces import every_piece, name_of_piece
from splinescope.session import Session
from splinescope.view import Piece, Selection

LOG = Path(__file__).parents[2] / "sample_logs" / "three_splines.log.gz"

FILE = file_of(open_log(LOG))


class AtOnce:
    """An estimator and an editor that do their work in this process, as soon as they are asked."""

    def __init__(self, hear: Callable[[Message], None]) -> None:
        self.job = 0
        self.asked: list[EditRequest] = []
        self.hear = hear
        self._jobs = EditJobs(hear)

    def _ask(self, request: EditRequest) -> int:
        self.job = request.job
        self.asked.append(request)
        return request.job

    def answer(self) -> None:
        """Do what was asked for."""
        while self.asked:
            self._jobs.do(self.asked.pop(0), lambda: False)

    def prepare(self, kept: bytes, config: SlamConfig) -> int:
        return self._ask(Prepare(self.job + 1, kept, config))

    def preview(self, in_force: tuple[Edit, ...], proposed: tuple[Edit, ...]) -> int:
        return self._ask(FindPreview(self.job + 1, in_force, proposed))

    def make(self, edits: tuple[Edit, ...], shown: tuple[Edit, ...]) -> int:
        return self._ask(MakeEdits(self.job + 1, edits, shown))

    def match(self, in_force: tuple[Edit, ...], earlier: int, scan: int, guess: np.ndarray) -> int:
        return self._ask(MatchLoop(self.job + 1, in_force, earlier, scan, guess))

    def hand_over(self, edits: tuple[Edit, ...]) -> int:
        return self._ask(HandOver(self.job + 1, edits))

    def cancel(self) -> None:
        """Nothing runs."""


class Idle:
    """An estimator that never answers: its messages are made by the test."""

    def process(self, log: LogFile, config: SlamConfig) -> int:
        return 1

    def solve(self, log: LogFile, result: PackedResult) -> int:
        self.solved = result.edits
        return 2

    def covariances(self, log: LogFile, result: PackedResult) -> int:
        self.asked_with = result.amended
        return 3

    def measure(self, result: PackedResult, first: Picked, second: Picked) -> int:
        return 4

    def cancel(self) -> None:
        """Nothing runs."""


class Desk:
    """A session with a finished run, and an editor that works when told."""

    def __init__(self, folder: Path, finished: list[Message], offered: bool = False, log: Path = LOG) -> None:
        self.folder = folder
        self.editor = AtOnce(lambda message: self.session.hear(message))
        journals = Journals(folder, offered=offered)
        self.estimator = Idle()
        self.session = Session(
            self.estimator,
            lambda _: None,
            Preferences(),
            editor=self.editor,
            journals=journals,  # type: ignore[arg-type]
        )
        request = ask.OpenLog(log)
        self.session.apply(request)
        self.session.apply(ask.LogOpened(request, open_log(log)))
        for message in finished:
            self.session.receive(message)
        self.editor.answer()

    @property
    def editing(self) -> Editing:
        return self.session.editing

    @property
    def journal(self) -> Path:
        (path,) = self.journals
        return path

    @property
    def journals(self) -> list[Path]:
        return sorted(self.folder.glob("*.edits"))

    def do(self, *commands: ask.Command) -> None:
        for command in commands:
            self.session.apply(command)
            self.editor.answer()

    @property
    def shown(self) -> str:
        """A hash of all that is shown of the result."""
        snapshot, digest = self.session.findings.snapshot, hashlib.sha256()
        assert snapshot is not None
        digest.update(snapshot.poses.tobytes())
        for spline in snapshot.map:
            digest.update(f"{spline.id} {spline.span} {spline.observations}".encode())
            digest.update(spline.curve.control_points.tobytes())
        for scan, step in sorted(self.session.findings.steps.items()):
            told = [(a.segment, a.first, a.last, a.spline, a.by) for a in step.associations]
            digest.update(f"{scan} {told}".encode())
        return digest.hexdigest()

    def piece(self, scan: int = 11) -> Association:
        step = self.session.findings.steps[scan]
        return max((a for a in step.associations if a.spline is not None), key=lambda a: a.last - a.first)

    def select(self, scan: int = 11) -> None:
        piece = self.piece(scan)
        self.do(ask.Seek(scan), ask.Select(Selection("segment", piece.segment)))

    def look_at_ignoring(self, scan: int) -> None:
        """Propose to ignore the longest piece of a scan, while the editor has not answered yet."""
        piece = self.piece(scan)
        for command in (ask.Seek(scan), ask.Select(Selection("segment", piece.segment))):
            self.session.apply(command)
        self.session.apply(ask.EditSelected(EditKind.IGNORE))


def pieces(desk: Desk, scan: int = 11) -> tuple[Piece, ...]:
    desk.do(ask.Seek(scan))
    shown = desk.session.scan_view
    assert shown is not None
    return tuple(map(name_of_piece, every_piece(shown)))
