"""Who computes, as seen from those who ask."""

from __future__ import annotations

from typing import Protocol

from bspline_slam.measuring import Picked
from bspline_slam.slam import SlamConfig
from splinescope.computing.messages import LogFile
from splinescope.computing.packed_result import PackedResult


class Estimator(Protocol):
    """Who computes: the worker's process, seen from here."""

    def process(self, log: LogFile, config: SlamConfig) -> int: ...
    def solve(self, log: LogFile, result: PackedResult) -> int: ...
    def covariances(self, log: LogFile, result: PackedResult) -> int: ...
    def measure(self, result: PackedResult, first: Picked, second: Picked) -> int: ...
    def cancel(self) -> None: ...
